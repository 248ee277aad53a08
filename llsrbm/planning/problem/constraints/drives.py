"""Limits of the joints' drives: torque, speed, and the torque that is left at a speed.

A drive gives its whole torque up to 70 % of its speed limit, from there less, none at the limit;
braking takes nothing away (`llsrbm.robots.drives.torques`). With t and w torque and speed as shares
of their limits this is a polygon,

    |t| <= 1,   |t + w / 0.3| <= 1 / 0.3,   |w| <= 1,

of which a plan may use the robot file's shares; the rest is for feedback.
"""

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.planning.problem.constraints.base import Bounds
from llsrbm.planning.problem.constraints.drive_rows import DriveConstraint
from llsrbm.planning.problem.constraints.drive_shares import (
    EDGE,
    at_middle_and_edge,
    available,
    compressed,
    of_planned,
    speed_shares,
)
from llsrbm.planning.problem.knots import Knots
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.limit_table import limits_called
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task
from llsrbm.robots.drives.torques import FULL_UP_TO

FALL = 1.0 - FULL_UP_TO
# What the check allows beyond the plan's share, of the limit at rest: the rows leave out how a
# leg's inertia changes with its posture and how the base gives way.
TORQUE_ALLOWANCE = 0.10
# Likewise of the speed limit: the rows are met in the middle of intervals by the model's legs.
SPEED_ALLOWANCE = 0.03
# As a body that has flipped touches down, its hips come down on nearly straight legs: in
# simulations knees reach 2.5 times their limit for some 20 ms after every flip. Plans within the
# limit are not found off boxes, and hide in a long first interval what they cannot stop. So rows
# of knees' speeds bound them no closer than this over the first interval. Those of the torque at
# speed do: a drive that brakes with all it has may turn 1.3 times as fast as its limit, no more.
OVERRUN = 3.0
KNEE = -1  # of a leg's joints, in the legs of robots that turn over: the last
# At lift-off and touchdown, where joints are fastest and only for an instant, plans may use all of
# a file's share of 0.9, and the check allows less.
AT_EDGES = 1 / 0.9
EDGE_ALLOWANCE = 0.01
# Rows are 1 to 4 % below the check there, for the base's place is a few millimetres off. With this
# much kept at first two thirds of the plans that it would object to are right at once.
SPEED_RESERVE, TORQUE_RESERVE = 0.02, 0.01
# The same for models that are there for comparison: they put the hips a centimetre or two off.
COMPARED_TORQUE_ALLOWANCE = 0.40
COMPARED_SPEED_ALLOWANCE = 0.25


class JointTorque(DriveConstraint):
    """|tau| <= share tau_max: contact forces and the leg's weight, and what swinging it takes."""

    name = "joint_torque"
    unit = "Nm"
    of_edges = False
    allowances = TORQUE_ALLOWANCE, COMPARED_TORQUE_ALLOWANCE
    limits = limits_called("torque_share", "drive_strength")

    def applies(self, role: Role) -> bool:
        """Over every interval."""
        return not role.terminal

    def shares(self, stage: Stage) -> Any:
        """Torques as shares of their limits."""
        return stage.joint_torques

    def arm_shares(self, stage: Stage) -> Any:
        return stage.arm_torques

    def scale(self, task: Task) -> float:
        return task.drive_strength

    def tops(self, task: Task) -> Array:
        """The robot file's share."""
        return np.full(2, self.share(task))

    def checked_shares(self, knots: Knots) -> Array:
        torque = knots.loads.joint_torque * self.share_of(knots)
        return at_middle_and_edge(torque, np.full_like(torque, np.nan))

    def share_of(self, knots: Knots) -> Array:
        return 1 / knots.task.robot.torque_limit

    def share(self, task: Task) -> float:
        return task.limits.torque_share

    def needed(self, knots: Knots) -> Array:
        return np.repeat(np.abs(knots.loads.joint_torque)[:, None], 2, axis=1)

    def allowed(self, knots: Knots, share: float) -> Array:
        """A share of what is available at the joints' speeds."""
        return share * available(knots)


class TorqueAtSpeed(JointTorque):
    """|tau / (share tau_max) + q' / (0.3 q'_max)| <= 1 / 0.3: less torque is left at speed."""

    name = "torque_at_speed"
    of_edges = True
    edge_reserve = TORQUE_RESERVE
    limits = ()
    limited_by = ("torque_share", "drive_strength", "battery")

    def shares(self, stage: Stage) -> Any:
        """The sum above, times 0.3; at edges with the interval's torque and the edge's speed."""
        limit = ca.DM(stage.model.drives.speed_limit.T)
        speeds, beside = stage.joint_rates / limit, list(stage.role.at_edge)
        torques = FALL * stage.joint_torques / stage.parameters["torque_share"]
        sums = torques + ca.horzcat(speeds, *(speeds[:, i] for i in stage.role.touching_down))
        if not beside:
            return sums
        return ca.horzcat(sums, torques[:, beside] + stage.edge_rates / limit[:, beside])

    def arm_shares(self, stage: Stage) -> Any:
        return FALL * stage.arm_torques / stage.parameters["torque_share"] + stage.arm_speeds

    def scale(self, task: Task) -> float:
        return task.battery

    def tops(self, task: Task) -> Array:
        return np.ones(2)

    def excess(self, knots: Knots) -> Array:
        """Nm, of sliding joints N, beyond the share of what is available at that speed."""
        allowed = self.allowed(knots, self.share(knots.task))
        beyond = super().allowance(knots)[0] * knots.task.robot.torque_limit
        return of_planned(self.needed(knots) - allowed - beyond, knots)

    def checked_shares(self, knots: Knots) -> Array:
        torque = knots.loads.joint_torque * self.share_of(knots)
        return torque[:, None] + speed_shares(knots)

    def share_of(self, knots: Knots) -> Array:
        return FALL / knots.task.limits.torque_share * super().share_of(knots)

    def allowance(self, knots: Knots) -> Array:
        return FALL / knots.task.limits.torque_share * super().allowance(knots)


class JointSpeed(DriveConstraint):
    """|q'| <= share q'_max."""

    name = "joint_speed"
    unit = "rad/s"
    of_both_ends = False
    edge_reserve = SPEED_RESERVE
    allowances = SPEED_ALLOWANCE, COMPARED_SPEED_ALLOWANCE
    limits = limits_called("speed_share", "battery")

    def applies(self, role: Role) -> bool:
        """Over every interval; not as a motion that is under way begins: that is as it is."""
        return not role.terminal and not (role.initial and role.under_way)

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Wider where knees may be overrun."""
        lower, upper = super().bounds(task, layout, knot)
        if not _overruns(task, layout.roles[knot]):
            return lower, upper
        legs, beside = task.robot.leg_joint_index, list(layout.roles[knot].at_edge)
        joints = np.concatenate([legs.ravel(), legs[beside].ravel(), task.free_arms])
        knees = np.isin(joints, legs[:, KNEE])
        top = compressed(self.scale(task) * OVERRUN, np.sqrt)
        return np.where(knees, -top, lower), np.where(knees, top, upper)

    def shares(self, stage: Stage) -> Any:
        """Speeds as shares of their limits."""
        limit, beside = ca.DM(stage.model.drives.speed_limit.T), list(stage.role.at_edge)
        shares = stage.joint_rates / limit
        return ca.horzcat(shares, stage.edge_rates / limit[:, beside]) if beside else shares

    def arm_shares(self, stage: Stage) -> Any:
        return stage.arm_speeds

    def scale(self, task: Task) -> float:
        return task.battery

    def tops(self, task: Task) -> Array:
        """The robot file's share, and more of it at edges."""
        return self.share(task) * np.array([1.0, AT_EDGES])

    def allowance(self, knots: Knots) -> Array:
        allowance = super().allowance(knots)
        if knots.model.is_true:
            allowance[EDGE] = EDGE_ALLOWANCE
        return allowance

    def checked_shares(self, knots: Knots) -> Array:
        """Where knees may be overrun, of what they may be overrun to."""
        return speed_shares(knots) * _overrun_by(knots)

    def share_of(self, knots: Knots) -> Array:
        return 1 / knots.task.robot.speed_limit

    def share(self, task: Task) -> float:
        return task.limits.speed_share

    def needed(self, knots: Knots) -> Array:
        return np.abs(speed_shares(knots)) * knots.task.robot.speed_limit

    def allowed(self, knots: Knots, share: float) -> Array:
        """More at edges, and of knees that may be overrun."""
        top = share * np.array([1.0, AT_EDGES])[:, None] * knots.task.robot.speed_limit
        return top / _overrun_by(knots)


def _overruns(task: Task, role: Role) -> bool:
    """Whether knees may be overrun over the interval: the first one after a flip."""
    return bool(role.lands_upright and role.landing and task.jump.pitch)


def _overrun_by(knots: Knots) -> Array:
    """(N, 1, J) the bound of a joint's rows as a share of what it may be overrun to, else 1."""
    task = knots.task
    factor = np.ones((len(knots.dt), 1, task.joints))
    for interval, role in enumerate(knots.layout.roles[: len(factor)]):
        if _overruns(task, role):
            factor[interval, 0, task.robot.leg_joint_index[:, KNEE]] = (
                task.limits.speed_share / OVERRUN
            )
    return factor


DRIVES: tuple[DriveConstraint, ...] = (JointTorque(), TorqueAtSpeed(), JointSpeed())
