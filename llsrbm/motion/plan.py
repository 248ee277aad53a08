"""`Plan`: the planned jump, one array a quantity, N + 1 knots."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.jump import Jump
from llsrbm.tuning import Tuning

Array = NDArray[np.float64]


class Phase(IntEnum):
    """Contact phases of a jump, in order."""

    TAKEOFF = 0
    FLIGHT = 1
    LANDING = 2

    @property
    def label(self) -> str:
        """As it is called in messages and files: "take-off", "flight", "landing"."""
        return {Phase.TAKEOFF: "take-off"}.get(self, self.name.lower())


@dataclass(frozen=True)
class Violation:
    """By how much one named constraint is violated, recomputed from the result.

    Attributes:
        amount: largest violation, in `unit`; 0 when satisfied.
        unit: SI unit of the amount.
        phase: where the largest violation is ("take-off", "flight", "landing").
        time: when, s.
    """

    amount: float
    unit: str
    phase: str
    time: float


@dataclass(frozen=True)
class SolveReport:
    """How the solver got there.

    Attributes:
        status: "solved" or "not-converged".
        solver: name of the solver ("fatrop", "ipopt").
        iterations: interior-point iterations of the attempt that is returned.
        attempts: initial guesses tried, 1 when the analytic one was enough.
        solve_time_s: wall time inside the solver, all attempts.
        total_time_s: wall time from request to `Plan`, solver already built.
        build_time_s: wall time to build or load the solver for this request, 0 when it was at hand.
        cost: value of the objective.
    """

    status: str
    solver: str
    iterations: int
    attempts: int
    solve_time_s: float
    total_time_s: float
    build_time_s: float
    cost: float


@dataclass(frozen=True, eq=False)
class Solution:
    """What the planner's solver found, in its own order and units: where a next solve may start.

    Attributes:
        variables: (n,).
        multipliers: (rows,) of its constraints.
    """

    variables: Array
    multipliers: Array


@dataclass(frozen=True, eq=False)
class Plan:
    """A planned jump at N + 1 knots: L legs, C contacts, J joints; world frame, SI units.

    Attributes:
        jump: the request.
        robot_parameters: the numbers of the robot that were used, as plain data.
        report: solver status and times.
        violations: constraint name -> largest violation, recomputed with NumPy.
        time: (N+1,) s, strictly increasing.
        phase: (N+1,) `Phase` of the interval that starts at the knot.
        com, com_velocity: (N+1, 3) m, m/s.
        base_quat: (N+1, 4) w, x, y, z: attitude of the URDF's root link.
        base_position: (N+1, 3) m: origin of the URDF's root link.
        angular_velocity: (N+1, 3) rad/s of the base.
        linear_momentum, angular_momentum: (N+1, 3) kg m/s, kg m2/s (about the CoM).
        inertia: (N+1, 3, 3) kg m2: the model's centroidal inertia.
        foot_position: (N+1, L, 3) m: contact point of a point foot, middle of a sole.
        foot_quat: (N+1, L, 4) w, x, y, z: of soles, which are level; identity for point feet.
        contact_point: (N+1, C, 3) m, legs x corners.
        contact_force: (N+1, C, 3) N, constant over the interval that starts at the knot.
        leg_mass: (L,) kg; base_mass: kg.
        leg_com: (N+1, L, 3) m: where the model puts each leg's point mass.
        joint_position: (N+1, J) rad or m; joint_names: their names.
        foot_in_hip: (N+1, L, d) m, rad: foot in the leg's mirrored hip frame as the model sees it
            (`llsrbm.models.base`), d = 4 with its yaw; linear in time between knots in flight.
        joint_velocity: (N+1, J) rad/s or m/s, zero at both ends.
        joint_torque: (N+1, J) Nm or N, by inverse dynamics of the whole body in the middle of the
            interval that starts at the knot (`llsrbm.analysis.joint_loads`); the last knot's are
            those of standing.
        joint_torque_limit: (N+1, J) Nm or N: the largest that the drives can give there, at that
            speed in the direction of the torque. These three are None where they are not known: in
            a plan of an old file whose robot is not there any more, and in one that failed so badly
            that its motion has no torques.
        tuning: weights and limits that were asked for in place of the robot's.
        solution: for plans that start from this one; None of a plan that failed or was read from a
            file, which does not hold it.
    """

    jump: Jump
    robot_parameters: dict[str, Any]
    report: SolveReport
    violations: dict[str, Violation]
    time: Array
    phase: NDArray[np.int64]
    com: Array
    com_velocity: Array
    base_quat: Array
    base_position: Array
    angular_velocity: Array
    linear_momentum: Array
    angular_momentum: Array
    inertia: Array
    foot_position: Array
    foot_quat: Array
    contact_point: Array
    contact_force: Array
    leg_mass: Array
    base_mass: float
    leg_com: Array
    joint_position: Array
    joint_names: tuple[str, ...]
    foot_in_hip: Array
    joint_velocity: Array | None = None
    joint_torque: Array | None = None
    joint_torque_limit: Array | None = None
    tuning: Tuning = field(default_factory=Tuning)
    solution: Solution | None = field(default=None, repr=False)

    @property
    def solved(self) -> bool:
        """Whether every constraint is satisfied."""
        return self.report.status == "solved"

    @property
    def duration(self) -> float:
        """Length of the motion, s."""
        return float(self.time[-1])

    @property
    def leg_names(self) -> tuple[str, ...]:
        """As in the robot file, when the plan says which robot it is of."""
        return leg_names(self.robot_parameters, len(self.leg_mass))

    @property
    def phase_start(self) -> Array:
        """(4,) s: start of take-off, flight, landing, and the end."""
        first = [int(np.argmax(self.phase == p)) for p in Phase]
        return np.append(self.time[first], self.time[-1])

    def save(self, path: str | Path) -> None:
        """Write the native npz file (schema llsrbm.plan/2); see `llsrbm.load`."""
        from llsrbm.motion.plan_file import save_plan

        save_plan(self, path)


def leg_names(robot_parameters: dict[str, Any], count: int) -> tuple[str, ...]:
    """As in the robot file, where a trajectory's numbers of the robot hold them."""
    legs = tuple(robot_parameters.get("legs", ()))
    return legs if len(legs) == count else tuple(f"leg{i}" for i in range(count))
