"""Joints keep off their mechanical stops."""

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.errors import JointNeed
from llsrbm.planning.problem.constraints.base import AgreedConstraint, Bounds, JointDemand
from llsrbm.planning.problem.constraints.drive_needs import when_in
from llsrbm.planning.problem.knots import Knots
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.limit_table import limits_called
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import RowBounds, Task

# How far beyond a stop the check lets models go that are there for comparison, a share of what lies
# between the stops: they put the hips a centimetre or two off.
COMPARED_ALLOWANCE = 0.10
# What shifted bounds keep of the check's stop, a share of what lies between, since the difference
# changes with the motion; and more where the check has objected before: a share of the excess.
RESERVE = 0.005
AGAIN_SHARE = 0.7


class JointStops(AgreedConstraint):
    """lower + margin <= q(x) <= upper - margin, of joints that may come near a stop at all.

    Angles are closed forms or fits of a foot's place (`llsrbm.models.leg_drives`), of free arms
    variables, which also stay within [arm_reach] of the robot's file. The check is by Pinocchio, at
    the knots and half way between them, and allows the margin.
    """

    name = "joint_stops"
    unit = "rad"
    limits = limits_called("stop_margin")

    def concerns(self, task: Task) -> bool:
        """True if the robot has a joint that may come near a stop."""
        return len(task.stopped_joints) > 0

    def applies(self, role: Role) -> bool:
        """Wherever the posture is free."""
        return not role.terminal and not role.initial

    def rows(self, stage: Stage) -> Any:
        """(joints that may stop, 1) rad or m."""
        drives = stage.model.drives
        angles = ca.vertcat(
            *(leg.angles(stage.feet_in_hip[:, i]) for i, leg in enumerate(drives.legs))
        )
        return ca.vertcat(angles[np.flatnonzero(drives.may_stop).tolist()], stage.arm_angles)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Within the stops by the margin, or where the whole body keeps to it."""
        joints = task.stopped_joints
        if self.name in task.agreed_bounds:
            shifted = task.agreed_bounds[self.name]
            return shifted.lower[knot, joints], shifted.upper[knot, joints]
        lower, upper = _ends(task)
        return lower[joints], upper[joints]

    def violation(self, knots: Knots) -> Array:
        """By Pinocchio, at each knot and over the interval after it."""
        excess, between = self._excesses(knots)
        amounts: Array = excess.max(axis=1)
        amounts[:-1] = np.maximum(amounts[:-1], between.max(axis=1))
        return np.maximum(amounts, 0.0)

    def agreed_bounds(self, knots: Knots) -> RowBounds:
        task, joints = knots.task, knots.task.stopped_joints
        room = np.diff(task.robot.joint_stops, axis=0)[0]
        angles, between = knots.postures.joint_position, knots.loads.joint_position
        rows = np.full(angles.shape, np.nan)
        if (known := knots.rows.get(self)) is not None and len(joints):
            rows[np.unique(known.knot)[:, None], joints] = known.values.reshape(-1, len(joints))
        beyond = [angles - rows]
        off = between - (rows[1:] + rows[:-1]) / 2
        beyond += [np.vstack([off, off[-1:]]), np.vstack([off[:1], off])]
        high, low = (np.nan_to_num(f.reduce(beyond)) for f in (np.fmax, np.fmin))
        before = task.agreed_bounds.get(self.name)
        reserve = np.zeros_like(angles)
        if before is not None:
            excess, after = self._excesses(knots)
            excess[:-1] = np.maximum(excess[:-1], after)
            reserve = before.reserve + AGAIN_SHARE * np.maximum(excess, 0.0)
        lower, upper = _ends(task)
        least, most = task.robot.joint_stops
        kept = RESERVE * room + reserve
        middle = (least + most) / 2
        return RowBounds(
            np.minimum(np.maximum(lower, least + kept - low), middle - RESERVE * room),
            np.maximum(np.minimum(upper, most - kept - high), middle + RESERVE * room),
            reserve,
        )

    def demand(self, knots: Knots) -> JointDemand | None:
        """The joint that is furthest beyond a stop, of what lies between."""
        task, room = knots.task, np.diff(knots.task.robot.joint_stops, axis=0)[0]
        excess = self._excesses(knots)[0] / room
        if not np.isfinite(excess).all() or excess.max() <= 0:
            return None
        knot, joint = (int(i) for i in np.unravel_index(np.argmax(excess), excess.shape))
        angle = float(knots.postures.joint_position[knot, joint])
        ends = task.robot.joint_stops[:, joint]
        stop = float(ends[np.argmin(np.abs(ends - angle))])
        interval = min(knot, len(knots.dt) - 1)
        return JointDemand(_need(knots, joint, angle, stop, interval), interval)

    def leaning(self, knots: Knots, knot: int, value: float) -> JointNeed | None:
        """The joint that is nearest to a stop."""
        task = knots.task
        if not len(task.stopped_joints):
            return None
        angles, (lower, upper) = knots.postures.joint_position[knot], task.robot.joint_stops
        joints = task.stopped_joints
        shares = np.minimum(angles - lower, upper - angles) / (upper - lower)
        joint = int(joints[np.argmin(shares[joints])])
        interval, angle = min(knot, len(knots.dt) - 1), float(angles[joint])
        return _need(knots, joint, angle, angle, interval)

    @staticmethod
    def _excesses(knots: Knots) -> tuple[Array, Array]:
        """(N+1, J) at the knots and (N, J) between them, rad or m; below zero where there is room.

        The first and the last posture are given, so nothing is counted there.
        """
        robot = knots.task.robot
        lower, upper = robot.joint_stops
        if not knots.model.is_true:
            allowed = COMPARED_ALLOWANCE * (upper - lower)
            lower, upper = lower - allowed, upper + allowed
        found = [
            np.maximum(lower - angles, angles - upper)
            for angles in (knots.postures.joint_position, knots.loads.joint_position)
        ]
        found[0][[0, -1]] = np.minimum(found[0][[0, -1]], 0.0)
        return found[0], found[1]


def _ends(task: Task) -> tuple[Array, Array]:
    """(J,) lower and upper ends that plans keep to, rad or m."""
    lower, upper = task.robot.joint_stops
    margin = task.limits.stop_margin * (upper - lower)
    lower, upper = lower + margin, upper - margin
    arms, (low, high) = task.robot.arm_joint_index, task.robot.arm_ends
    lower[arms], upper[arms] = np.maximum(lower[arms], low), np.minimum(upper[arms], high)
    return lower, upper


def _need(knots: Knots, joint: int, needed: float, has: float, interval: int) -> JointNeed:
    name = knots.task.robot.joint_names[joint]
    unit = "m" if name in knots.task.robot.sliding_joints else "rad"
    return JointNeed(name, needed, has, unit, when_in(knots.loads, interval))
