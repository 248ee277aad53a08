"""The laws of motion beside the dynamics, and where the motion ends."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.planning.problem.constraints.base import Array, Bounds, Constraint
from llsrbm.planning.problem.layout import Layout, Role
from llsrbm.planning.problem.stage import BALANCE_SCALE, Stage
from llsrbm.planning.problem.task import Task

# Of the way from the middle of the feet to the nearest of them: forces can still be shared by all.
INSIDE = 0.4


class MomentumBalance(Constraint):
    """I omega + h = R^T L over each interval (eqs. 3, 4; `llsrbm-plus`: with h).

    Where the model was found to be wrong, with what it lacks (`Task.correction`).

    I, h and R at the midpoint, L its mean over the interval.
    """

    name = "momentum_balance"
    unit = "kg m2/s"
    equality = True

    def applies(self, role: Role) -> bool:
        """Over every interval."""
        return not role.terminal

    def rows(self, stage: Stage) -> Any:
        """(3, 1)."""
        return stage.balance

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Zero."""
        return np.zeros(3), np.zeros(3)

    def measured(self, rows: Array, task: Task) -> Array:
        """kg m2/s."""
        return rows * (task.mass / BALANCE_SCALE)


MOMENTUM_BALANCE = MomentumBalance()


class FinalState(Constraint):
    """x[N] = x_fin: CoM, attitude and velocity as the target says; no angular momentum.

    Where feet land elsewhere the CoM ends above them. A motion that is planned anew under way has
    room horizontally (`FinalPlace`): where it comes to rest it could not choose in time.
    """

    name = "final_state"
    unit = "m, rad, m/s, m2/s"
    equality = True

    def applies(self, role: Role) -> bool:
        """At the end."""
        return role.terminal

    def rows(self, stage: Stage) -> Any:
        """(12, 1), under way (10, 1): position, vector part of the turn left, velocity, L / m."""
        w, xyz = stage.parameters["goal_quat"][0], stage.parameters["goal_quat"][1:]
        q = stage.quat
        turn = w * q[1:] - q[0] * xyz - ca.cross(xyz, q[1:])
        off = stage.off_goal
        return ca.vertcat(
            off[2] if stage.layout.under_way else off,
            turn,
            stage.velocity - stage.parameters["goal_velocity"],
            stage.momentum,
        )

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Zero."""
        return (np.zeros(10 if layout.under_way else 12),) * 2

    def measured(self, rows: Array, task: Task) -> Array:
        """The turn left as an angle."""
        out = rows.copy()
        out[-9:-6] = 2 * np.arcsin(min(float(np.linalg.norm(rows[-9:-6])), 1.0))
        return out


class FinalPlace(Constraint):
    """A motion planned anew ends with its CoM well inside of where its feet stand."""

    name = "final_place"
    unit = "m"

    def applies(self, role: Role) -> bool:
        """At the end of a motion that began under way."""
        return role.terminal and role.under_way

    def rows(self, stage: Stage) -> Any:
        """(2, 1) m: how far the CoM is from its target above the feet, along the target's axes."""
        return stage.off_goal[:2]

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """A share of the way to the outermost contact point."""
        last = task.places[-1]
        top = INSIDE * np.abs(last.contacts[:, :2] - task.goal_position[:2]).min(axis=0)
        return -top, top
