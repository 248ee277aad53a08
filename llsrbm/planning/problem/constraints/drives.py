"""Limits of the joints' drives: torque, speed, and the torque that is left at a speed.

A drive gives its whole torque up to 70 % of its speed limit, from there less, none at the limit;
braking takes nothing away (`llsrbm.robots.drives.torques`). With t and w torque and speed as shares
of their limits this is a polygon,

    |t| <= 1,   |t + w / 0.3| <= 1 / 0.3,   |w| <= 1,

of which a plan may use the robot file's shares; the rest is for feedback.
"""

from __future__ import annotations

from typing import Any, ClassVar

import casadi as ca
import numpy as np

from llsrbm.errors import JointNeed
from llsrbm.planning.problem.constraints.base import Array, Bounds, JointDemand, Limit
from llsrbm.planning.problem.constraints.drive_rows import (
    EDGE,
    MIDDLE,
    DriveConstraint,
    Place,
    at_middle_and_edge,
    of_planned,
    tamed,
    when_in,
)
from llsrbm.planning.problem.knots import Knots
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task
from llsrbm.robots.drives.torques import FULL_UP_TO
from llsrbm.robots.robot import Robot

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
    limits: ClassVar[tuple[Limit, ...]] = (
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

    def arm_shares(self, stage: Stage) -> Any:
        return stage.arm_torques

    def tops(self, task: Task) -> Array:
        """The robot file's share."""
        return np.full(2, task.limits.torque_share)

    def checked_shares(self, knots: Knots) -> Array:
        torque = knots.loads.joint_torque * self.share_of(knots)
        return at_middle_and_edge(torque, np.full_like(torque, np.nan))

    def share_of(self, knots: Knots) -> Array:
        share: Array = 1 / knots.task.robot.torque_limit
        return share

    def _has(self, knots: Knots, place: Place, value: float) -> tuple[float, str]:
        robot, joint = knots.task.robot, place[-1]
        return value * float(_available(knots)[place]), torque_unit(robot, robot.joint_names[joint])

    def demand(self, knots: Knots) -> JointDemand | None:
        """The torque that exceeds its share most, at rest or at speed."""
        return torque_demand(knots)


class TorqueAtSpeed(JointTorque):
    """|tau / (share tau_max) + q' / (0.3 q'_max)| <= 1 / 0.3: less torque is left at speed."""

    name = "torque_at_speed"
    of_edges = True
    edge_reserve = TORQUE_RESERVE
    limits = ()
    limited_by = ("torque_share",)

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

    def tops(self, task: Task) -> Array:
        return np.ones(2)

    def excess(self, knots: Knots) -> Array:
        """Nm, of sliding joints N, beyond the share of what is available at that speed."""
        loads, task = knots.loads, knots.task
        allowed = super().allowance(knots)[0] * task.robot.torque_limit
        torque = np.abs(loads.joint_torque)[:, None]
        return of_planned(torque - task.limits.torque_share * _available(knots) - allowed, knots)

    def checked_shares(self, knots: Knots) -> Array:
        torque = knots.loads.joint_torque * self.share_of(knots)
        return torque[:, None] + _speed_shares(knots)

    def share_of(self, knots: Knots) -> Array:
        return FALL / knots.task.limits.torque_share * super().share_of(knots)

    def allowance(self, knots: Knots) -> Array:
        return FALL / knots.task.limits.torque_share * super().allowance(knots)


class JointSpeed(DriveConstraint):
    """|q'| <= share q'_max, where joints are fast: in flight and right beside it.

    The check is of all intervals: legs of standing feet are slow, and have no rows for it.
    """

    name = "joint_speed"
    unit = "rad/s"
    of_both_ends = False
    edge_reserve = SPEED_RESERVE
    allowances = SPEED_ALLOWANCE, COMPARED_SPEED_ALLOWANCE
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

    def bounds(self, task: Task, layout: Layout, knot: int) -> Bounds:
        """Wider where knees may be overrun."""
        lower, upper = super().bounds(task, layout, knot)
        if not _overruns(task, layout.roles[knot]):
            return lower, upper
        legs, beside = task.robot.leg_joint_index, list(layout.roles[knot].at_edge)
        joints = np.concatenate([legs.ravel(), legs[beside].ravel(), task.free_arms])
        knees, top = np.isin(joints, legs[:, KNEE]), tamed(OVERRUN, np.sqrt)
        return np.where(knees, -top, lower), np.where(knees, top, upper)

    def shares(self, stage: Stage) -> Any:
        """Speeds as shares of their limits."""
        limit, beside = ca.DM(stage.model.drives.speed_limit.T), list(stage.role.at_edge)
        shares = stage.joint_rates / limit
        return ca.horzcat(shares, stage.edge_rates / limit[:, beside]) if beside else shares

    def arm_shares(self, stage: Stage) -> Any:
        return stage.arm_speeds

    def tops(self, task: Task) -> Array:
        """The robot file's share, and more of it at edges."""
        return task.limits.speed_share * np.array([1.0, AT_EDGES])

    def allowance(self, knots: Knots) -> Array:
        allowance = super().allowance(knots)
        if knots.model.is_true:
            allowance[EDGE] = EDGE_ALLOWANCE
        return allowance

    def checked_shares(self, knots: Knots) -> Array:
        """Where knees may be overrun, of what they may be overrun to."""
        shares, task = _speed_shares(knots), knots.task
        knees = task.robot.leg_joint_index[:, KNEE]
        for interval, role in enumerate(knots.layout.roles[: len(shares)]):
            if _overruns(task, role):
                shares[interval][:, knees] *= task.limits.speed_share / OVERRUN
        return shares

    def share_of(self, knots: Knots) -> Array:
        share: Array = 1 / knots.task.robot.speed_limit
        return share

    def _has(self, knots: Knots, place: Place, value: float) -> tuple[float, str]:
        robot, (_, where, joint) = knots.task.robot, place
        has = value * (AT_EDGES if where == EDGE else 1.0) * float(robot.speed_limit[joint])
        return has, speed_unit(robot, robot.joint_names[joint])

    def demand(self, knots: Knots) -> JointDemand | None:
        """The speed that exceeds its share most."""
        robot, shares = knots.task.robot, np.abs(self.checked_shares(knots))
        tops = self.tops(knots.task)
        place = _largest(of_planned(shares - tops[:, None], knots))
        if place is None:
            return None
        interval, where, joint = place
        name, limit = robot.joint_names[joint], float(robot.speed_limit[joint])
        unit, when = speed_unit(robot, name), when_in(knots.loads, interval)
        of = limit * float(np.abs(_speed_shares(knots)[place]) / shares[place])
        need = JointNeed(name, shares[place] * of, tops[where] * of, unit, when)
        return JointDemand(need, interval)


def torque_demand(knots: Knots) -> JointDemand | None:
    """The torque that exceeds the plans' share of what is available most, of the limit at rest."""
    loads, robot = knots.loads, knots.task.robot
    has = knots.task.limits.torque_share * _available(knots)
    torque = np.abs(loads.joint_torque)
    place = _largest(of_planned((torque[:, None] - has) / robot.torque_limit, knots))
    if place is None:
        return None
    interval, _, joint = place
    name = robot.joint_names[joint]
    unit, when = torque_unit(robot, name), when_in(loads, interval)
    return JointDemand(JointNeed(name, torque[interval, joint], has[place], unit, when), interval)


def _available(knots: Knots) -> Array:
    """(N, 2, J) Nm or N; infinite where there is no edge."""
    edge = np.where(np.isnan(_edge_velocity(knots)), np.inf, knots.loads.edge_available)
    return at_middle_and_edge(knots.loads.torque_available, edge)


def _speed_shares(knots: Knots) -> Array:
    """(N, 2, J) of the limits; NaN where there is no edge."""
    shares = at_middle_and_edge(knots.loads.joint_velocity, _edge_velocity(knots))
    return shares / knots.task.robot.speed_limit


def _overruns(task: Task, role: Role) -> bool:
    """Whether knees may be overrun over the interval: the first one after a flip."""
    return bool(role.lands_upright and role.landing and task.jump.pitch)


def _edge_velocity(knots: Knots) -> Array:
    """(N, J) rad/s or m/s; NaN where no rows are, see `Role.at_edge`."""
    velocity = knots.loads.edge_velocity.copy()
    for interval, role in enumerate(knots.layout.roles[: len(velocity)]):
        for leg in {*role.landing} - {*role.at_edge}:
            velocity[interval, knots.task.robot.leg_joint_index[leg]] = np.nan
    return velocity


def torque_unit(robot: Robot, joint: str) -> str:
    """Unit of what its drive gives."""
    return "N" if joint in robot.sliding_joints else "Nm"


def speed_unit(robot: Robot, joint: str) -> str:
    """Unit of how fast it moves."""
    return "m/s" if joint in robot.sliding_joints else "rad/s"


def _largest(excess: Array) -> Place | None:
    """Where the largest of (N, 2, J) is; None if nothing is exceeded, or by no number."""
    if np.isnan(excess[:, MIDDLE]).any() or not 0 < np.nanmax(excess) < np.inf:
        return None
    interval, where, joint = np.unravel_index(np.nanargmax(excess), excess.shape)
    return int(interval), int(where), int(joint)


DRIVES: tuple[DriveConstraint, ...] = (JointTorque(), TorqueAtSpeed(), JointSpeed())
