"""Limits of the joints' drives: torque, speed, and the torque that is left at a speed.

A drive gives its whole torque up to 70 % of its speed limit, from there less, none at the limit;
braking takes nothing away (`llsrbm.robots.drives`). With t and w torque and speed as shares of
their limits this is a polygon,

    |t| <= 1,   |t + w / 0.3| <= 1 / 0.3,   |w| <= 1,

of which a plan may use the robot file's shares; the rest is for feedback. The rows take torques
and speeds from closed forms or fits (`llsrbm.models.leg_drives`) in the middle of each interval.
The check recomputes them with Pinocchio: inverse dynamics of the whole body in the postures that
realise the plan (`llsrbm.body.joint_loads`).
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar

import casadi as ca
import numpy as np

from llsrbm.body.joint_loads import JointLoads
from llsrbm.body.peak_loads import event_beside, when_in_words
from llsrbm.planning.problem.constraints.base import (
    Array,
    Bounds,
    Constraint,
    JointDemand,
    Limit,
    spread,
)
from llsrbm.planning.problem.knots import Knots
from llsrbm.planning.problem.layout import Layout, Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task
from llsrbm.robots.drives import FULL_UP_TO

FALL = 1.0 - FULL_UP_TO
# What the check allows beyond the plan's share, of the limit at rest: the rows leave out how a
# leg's inertia changes with its posture and how the base gives way.
TORQUE_ALLOWANCE = 0.10
# Likewise of the speed limit: the rows are met in the middle of intervals by the model's legs.
SPEED_ALLOWANCE = 0.03
# The same for models that are there for comparison: they put the hips a centimetre or two off.
COMPARED_TORQUE_ALLOWANCE = 0.40
COMPARED_SPEED_ALLOWANCE = 0.25
# Beyond so many times the limit rows grow with its root: near a straight leg shares of thousands
# come up on the way to a solution, and slopes of millions, with which Fatrop may look for a
# direction for ever. At the limit 0.2 % are left out.
FAR_BEYOND = 10.0
# A drive that has more than this of its torque is not said to have lost any.
WHOLE = 0.99


class _DriveConstraint(Constraint):
    """Rows of all joints, symmetric bounds.

    Attributes:
        of_both_ends: whether the last interval of a swing has rows for its end too.
    """

    of_both_ends: ClassVar[bool] = True

    def rows(self, stage: Stage) -> Any:
        """(n L, 1)."""
        return _tamed(ca.vec(self.shares(stage)))

    @abstractmethod
    def shares(self, stage: Stage) -> Any:
        """(n, L) what is bounded."""

    @abstractmethod
    def top(self, task: Task) -> float:
        """The bound of all rows."""

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Plus and minus the share."""
        ends = len(layout.roles[knot].settling) if self.of_both_ends else 0
        rows = task.joints // layout.legs * (layout.legs + ends)
        top = np.full(rows, _tamed(self.top(task)))
        return -top, top

    def violation(self, knots: Knots) -> Array:
        """By Pinocchio, over each interval."""
        return spread(knots, self.excess(knots))

    @abstractmethod
    def excess(self, knots: Knots) -> Array:
        """(N, J) in the constraint's unit; below zero where there is room."""


class JointTorque(_DriveConstraint):
    """|tau| <= share tau_max: contact forces and the leg's weight, and what swinging it takes."""

    name = "joint_torque"
    unit = "Nm"
    limits = (
        Limit(
            "torque_share",
            "share of the drives' torque",
            "1",
            "plans may use more of the drives' torque; less of it is left for feedback",
            lowest=0.2,
            highest=3.0,
            place=("limits", "torque_share"),
        ),
    )

    def applies(self, role: Role) -> bool:
        """Over every interval but the first of a plan from rest, where the robot stands."""
        return not role.terminal and (not role.initial or role.under_way)

    def shares(self, stage: Stage) -> Any:
        """Torques as shares of their limits."""
        return stage.joint_torques

    def top(self, task: Task) -> float:
        """The robot file's share."""
        return task.limits.torque_share

    def excess(self, knots: Knots) -> Array:
        """Nm, of sliding joints N, beyond the share of the limit at rest."""
        limit = knots.task.robot.torque_limit
        share = knots.task.limits.torque_share + _torque_allowance(knots)
        excess: Array = np.abs(knots.loads.joint_torque) - share * limit
        return excess

    def demand(self, knots: Knots) -> JointDemand | None:
        """The torque that exceeds its share most, at rest or at speed."""
        return torque_demand(knots)


class TorqueAtSpeed(_DriveConstraint):
    """|tau / (share tau_max) + q' / (0.3 q'_max)| <= 1 / 0.3: less torque is left at speed."""

    name = "torque_at_speed"
    unit = "Nm"
    limited_by = ("torque_share",)

    def applies(self, role: Role) -> bool:
        """Over every interval but the first of a plan from rest, where the robot stands."""
        return not role.terminal and (not role.initial or role.under_way)

    def shares(self, stage: Stage) -> Any:
        """The sum above, times 0.3."""
        speeds = stage.joint_rates / ca.DM(stage.model.drives.speed_limit.T)
        torques = FALL * stage.joint_torques / stage.parameters["torque_share"]
        return torques + ca.horzcat(speeds, *(speeds[:, i] for i in stage.role.settling))

    def top(self, task: Task) -> float:
        return 1.0

    def excess(self, knots: Knots) -> Array:
        """Nm, of sliding joints N, beyond the share of what is available at that speed."""
        loads, limits = knots.loads, knots.task.limits
        allowed = _torque_allowance(knots) * knots.task.robot.torque_limit
        excess: Array = (
            np.abs(loads.joint_torque) - limits.torque_share * loads.torque_available - allowed
        )
        return excess

    def demand(self, knots: Knots) -> JointDemand | None:
        return torque_demand(knots)


class JointSpeed(_DriveConstraint):
    """|q'| <= share q'_max, where joints are fast: in flight and right beside it."""

    name = "joint_speed"
    unit = "rad/s"
    of_both_ends = False
    limits = (
        Limit(
            "speed_share",
            "share of the drives' speed",
            "1",
            "joints may turn faster; less is left for feedback",
            lowest=0.2,
            highest=3.0,
            place=("limits", "speed_share"),
        ),
    )

    def applies(self, role: Role) -> bool:
        """While feet swing, in the interval before that and in the one after it."""
        return role.moves_feet and not role.terminal and not role.initial

    def shares(self, stage: Stage) -> Any:
        """Speeds as shares of their limits."""
        return stage.joint_rates / ca.DM(stage.model.drives.speed_limit.T)

    def top(self, task: Task) -> float:
        """The robot file's share."""
        return task.limits.speed_share

    def excess(self, knots: Knots) -> Array:
        """rad/s, of sliding joints m/s, beyond the share."""
        allowance = SPEED_ALLOWANCE if knots.model.is_true else COMPARED_SPEED_ALLOWANCE
        share = knots.task.limits.speed_share + allowance
        excess: Array = np.abs(knots.loads.joint_velocity) - share * knots.task.robot.speed_limit
        return excess

    def demand(self, knots: Knots) -> JointDemand | None:
        """The speed that exceeds its share most."""
        loads, robot = knots.loads, knots.task.robot
        share, speed = knots.task.limits.speed_share, np.abs(loads.joint_velocity)
        place = _largest(speed / robot.speed_limit - share)
        if place is None:
            return None
        joint, limit = loads.joint_names[place[1]], robot.speed_limit[place[1]]
        sliding = joint in robot.sliding_joints
        verb, unit = ("slide", "m/s") if sliding else ("turn", "rad/s")
        return JointDemand(
            f"{joint} would have to {verb} at {_number(speed[place])} {unit} "
            f"{_when(loads, place[0])}, {100 * speed[place] / limit:.0f} % of its drive's "
            f"{_number(limit)} {unit}; plans may use {100 * share:.0f} % (speed_share)",
            place[0],
        )


def _tamed(share: Any) -> Any:
    """A share, or its bound, as a row: increasing, and far beyond the limit ever slower."""
    return share / ca.sqrt(ca.sqrt(1 + (share / FAR_BEYOND) ** 2))


def torque_demand(knots: Knots) -> JointDemand | None:
    """The torque that exceeds the plans' share of what is available most, of the limit at rest."""
    loads, robot = knots.loads, knots.task.robot
    share, torque = knots.task.limits.torque_share, np.abs(loads.joint_torque)
    place = _largest((torque - share * loads.torque_available) / robot.torque_limit)
    if place is None:
        return None
    joint, limit = loads.joint_names[place[1]], robot.torque_limit[place[1]]
    sliding = joint in robot.sliding_joints
    unit, speed_unit = ("N", "m/s") if sliding else ("Nm", "rad/s")
    need = f"{joint} would need {_number(torque[place])} {unit} {_when(loads, place[0])}"
    share_text = f"plans may use {100 * share:.0f} %"
    available = loads.torque_available[place]
    if available > WHOLE * limit:
        percent = 100 * torque[place] / limit
        has = f"{percent:.0f} % of its drive's {_number(limit)} {unit}; {share_text}"
    else:
        speed = _number(abs(loads.joint_velocity[place]))
        has = (
            f"its drive has {_number(available)} {unit} left at {speed} {speed_unit}; "
            f"{share_text} of that"
        )
    return JointDemand(f"{need}, {has} (torque_share)", place[0])


def _largest(excess: Array) -> tuple[int, int] | None:
    """Interval and joint of the largest of (N, J); None if nothing is exceeded, or by no number."""
    if not np.isfinite(excess).all() or excess.max() <= 0:
        return None
    k, j = np.unravel_index(np.argmax(excess), excess.shape)
    return int(k), int(j)


def _when(loads: JointLoads, interval: int) -> str:
    phase = loads.schedule[int(loads.phase[interval])].name
    return when_in_words(phase, loads.time[interval], event_beside(loads.contact, interval))


def _number(value: float) -> str:
    """Two digits, and all before the point."""
    return f"{value:.0f}" if value >= 10 else f"{value:.2g}"


def _torque_allowance(knots: Knots) -> float:
    return TORQUE_ALLOWANCE if knots.model.is_true else COMPARED_TORQUE_ALLOWANCE
