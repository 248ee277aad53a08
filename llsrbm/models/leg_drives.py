"""Rates and torques of a leg's joints, as functions of its foot's place and the force on it.

The planner knows feet, not joints. For its limits on drives it needs, of each leg,

    q'   = r(x, x')                     joint rates, rad/s or m/s
    tau  = -J^T (f, m)                  joint torques that hold a force and a moment at the foot
    q''  = d/dt r(x, x')                joint accelerations, for what swinging the leg takes

as expressions in x, the foot in its mirrored hip frame (`llsrbm.models.base`), and where the knee
is, which must not run into anything. There are two kinds of legs: `llsrbm.models.knee_leg` with
closed forms and `llsrbm.models.fitted_leg` for any other.

The matrices may be CasADi SX or DM.
"""

from abc import ABC, abstractmethod
from typing import Any

import casadi as ca

Matrix = Any  # casadi.SX or casadi.DM


class LegDrives(ABC):
    """Joint rates and torques of one leg of n joints, from the base outwards."""

    joints: int  # n

    @abstractmethod
    def angles(self, x: Matrix) -> Matrix:
        """q (n, 1) rad or m."""

    @abstractmethod
    def rates(self, x: Matrix, x_rate: Matrix) -> Matrix:
        """q' (n, 1), linear in `x_rate`; `x`: (d, 1) m, rad: the foot in its mirrored hip frame."""

    @abstractmethod
    def holding_torque(self, x: Matrix, force: Matrix, moment: Matrix | None) -> Matrix:
        """-J^T (f, m), (n, 1) Nm or N, linear in force and moment, (3, 1) on the foot, base axes.

        The moment is about the foot's frame; None of points.
        """

    @abstractmethod
    def knee(self, x: Matrix) -> Matrix | None:
        """The knee seen from the hip, (3, 1) m, base axes; None of legs that have none."""

    @abstractmethod
    def numbers(self) -> dict[str, Any]:
        """Numbers computed from the robot, for keys of caches."""

    def accelerations(self, x: Matrix, x_rate: Matrix, x_acceleration: Matrix) -> Matrix:
        """q'' (n, 1) rad/s2 or m/s2."""
        return self.rates(x, x_acceleration) + ca.jtimes(self.rates(x, x_rate), x, x_rate)
