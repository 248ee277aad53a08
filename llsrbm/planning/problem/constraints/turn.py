"""Angles and rates of soles about the vertical; points have no such rows."""

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.planning.problem.constraints.base import Bounds, Constraint
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.limit_table import limits_called
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task


class FootYaw(Constraint):
    """A foot's yaw against the base stays in the robot file's range, outwards positive."""

    name = "foot_yaw"
    unit = "rad"
    limits = limits_called("foot_yaw_min", "foot_yaw_max")

    def concerns(self, task: Task) -> bool:
        """Soles only."""
        return not task.foot.is_point

    def applies(self, role: Role) -> bool:
        """Wherever the posture is free."""
        return not role.terminal and not role.initial

    def rows(self, stage: Stage) -> Any:
        """(L, 1) rad."""
        return ca.vec(stage.feet_in_hip[3:, :])

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """The range."""
        low, high = task.foot.yaw
        rows = layout.legs if layout.foot_coordinates > 3 else 0
        return np.full(rows, low), np.full(rows, high)


class FootTurn(Constraint):
    """Turning rates of feet in flight, against the base and in the world."""

    name = "foot_turn"
    unit = "rad/s"
    limits = limits_called("foot_turn_speed")

    def concerns(self, task: Task) -> bool:
        """Soles only."""
        return not task.foot.is_point

    def applies(self, role: Role) -> bool:
        """While feet swing; not as a motion that is under way begins: that is as it is."""
        return bool(role.swinging) and not role.initial

    def rows(self, stage: Stage) -> Any:
        """(2 swinging, 1) rad/s."""
        rates = stage.feet_mid[1]
        of_feet = [rates[3:, i] for i in stage.role.swinging]
        return ca.vertcat(*of_feet, stage.foot_turn)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Plus and minus the limit."""
        role = layout.roles[knot]
        turning = len(role.swinging) if layout.foot_coordinates > 3 else 0
        limit = np.full(2 * turning, task.foot.turn_speed)
        return -limit, limit
