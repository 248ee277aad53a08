"""Limits of the joints' drives: torque, speed, and the torque that is left at a speed.

A drive gives its whole torque up to 70 % of its speed limit, from there less, none at the limit;
braking takes nothing away (`llsrbm.robots.drives`). With t and w torque and speed as shares of
their limits this is a polygon,

    |t| <= 1,   |t + w / 0.3| <= 1 / 0.3,   |w| <= 1,

of which a plan may use the robot file's shares; the rest is for feedback. The rows take torques
and speeds from closed forms or fits (`llsrbm.models.leg_drives`) in the middle of each interval.
The check recomputes them with Pinocchio: inverse dynamics of the whole body in the postures that
realise the plan (`llsrbm.body.joint_loads`). Where it objects, the rows' bounds are shifted by what
they differ from it (`agreed_bounds`).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray

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
from llsrbm.planning.problem.task import DriveBounds, Task
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
# Of what the check allows shifted bounds keep this share of the limit, since the difference changes
# with the motion, and more where the check has objected before: a share of the excess, and this.
RESERVE = 0.006
AGAIN, AGAIN_SHARE = 0.003, 0.7
# Shifted bounds leave the rows this much on either side.
LEAST = 0.03
# A drive that has more than this of its torque is not said to have lost any.
WHOLE = 0.99


class _DriveConstraint(Constraint):
    """Rows of all joints, symmetric bounds.

    Attributes:
        of_both_ends: whether the last interval of a swing has rows for its end too.
        load: the attribute of `JointLoads` that is bounded.
        allowances: shares that the check allows beyond, and those for compared models.
    """

    of_both_ends: ClassVar[bool] = True
    load: ClassVar[str]
    allowances: ClassVar[tuple[float, float]]

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
        """Plus and minus the share, or where the whole body keeps to it."""
        landing = layout.roles[knot].settling if self.of_both_ends else ()
        if self.name in task.drive_bounds:
            shifted, legs = task.drive_bounds[self.name], task.robot.leg_joint_index
            joints = np.concatenate([legs.ravel(), legs[list(landing)].ravel()])
            ends = shifted.lower[knot, joints], shifted.upper[knot, joints]
            return _tamed(ends[0], np.sqrt), _tamed(ends[1], np.sqrt)
        rows = task.joints // layout.legs * (layout.legs + len(landing))
        top = np.full(rows, _tamed(self.top(task)))
        return -top, top

    def violation(self, knots: Knots) -> Array:
        """By Pinocchio, over each interval."""
        return spread(knots, self.excess(knots))

    def excess(self, knots: Knots) -> Array:
        """(N, J) in the constraint's unit; below zero where there is room."""
        edge = self.top(knots.task) + self.allowance(knots)
        excess: Array = (np.abs(self.checked_shares(knots)) - edge) / self.share_of(knots)
        return excess

    def checked_shares(self, knots: Knots) -> Array:
        """(N, J) as the rows have them, by Pinocchio."""
        shares: Array = getattr(knots.loads, self.load) * self.share_of(knots)
        return shares

    @abstractmethod
    def share_of(self, knots: Knots) -> Array:
        """(J,) shares, as rows have them, of one in the constraint's unit."""

    def allowance(self, knots: Knots) -> float:
        """Amount beyond `top` that the check allows, as rows have it."""
        own, compared = self.allowances
        return own if knots.model.is_true else compared

    def agreed_bounds(self, knots: Knots) -> DriveBounds:
        """Bounds of the rows at which the check holds, if the two differ as in this motion."""
        both = _swings_on(knots) & self.of_both_ends
        rows = self._row_shares(knots)
        here = np.where(both, (rows[:-1] + rows[1:]) / 2, rows[:-1])
        beyond = np.nan_to_num(self.checked_shares(knots) - here).clip(-0.5, 0.5)
        known = knots.task.drive_bounds.get(self.name)
        reserve = np.zeros_like(rows)
        if known is not None:
            excess = self.excess(knots) * self.share_of(knots)
            more = np.where(excess > 0, AGAIN_SHARE * excess + AGAIN, 0.0)
            reserve = known.reserve + _on_rows(more, both, np.maximum)
        top = self.top(knots.task)
        edge = top + self.allowance(knots) - reserve
        upper = np.minimum(top, edge - RESERVE - _on_rows(beyond, both, np.maximum))
        lower = np.maximum(-top, RESERVE - edge - _on_rows(beyond, both, np.minimum))
        return DriveBounds(np.minimum(lower, -LEAST), np.maximum(upper, LEAST), reserve)

    def _row_shares(self, knots: Knots) -> Array:
        """(N+1, J) by the rows of legs; NaN where there are none."""
        legs = knots.task.robot.leg_joint_index.ravel()
        shares = np.full((len(knots.time), len(legs)), np.nan)
        if (rows := knots.rows.get(self)) is not None:
            for knot in np.unique(rows.knot):
                shares[knot, legs] = _untamed(rows.values[rows.knot == knot][: len(legs)])
        return shares


class JointTorque(_DriveConstraint):
    """|tau| <= share tau_max: contact forces and the leg's weight, and what swinging it takes."""

    name = "joint_torque"
    unit = "Nm"
    load = "joint_torque"
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

    def top(self, task: Task) -> float:
        """The robot file's share."""
        return task.limits.torque_share

    def share_of(self, knots: Knots) -> Array:
        share: Array = 1 / knots.task.robot.torque_limit
        return share

    def demand(self, knots: Knots) -> JointDemand | None:
        """The torque that exceeds its share most, at rest or at speed."""
        return torque_demand(knots)


class TorqueAtSpeed(JointTorque):
    """|tau / (share tau_max) + q' / (0.3 q'_max)| <= 1 / 0.3: less torque is left at speed."""

    name = "torque_at_speed"
    limits = ()
    limited_by = ("torque_share",)

    def shares(self, stage: Stage) -> Any:
        """The sum above, times 0.3."""
        speeds = stage.joint_rates / ca.DM(stage.model.drives.speed_limit.T)
        torques = FALL * stage.joint_torques / stage.parameters["torque_share"]
        return torques + ca.horzcat(speeds, *(speeds[:, i] for i in stage.role.settling))

    def top(self, task: Task) -> float:
        return 1.0

    def excess(self, knots: Knots) -> Array:
        """Nm, of sliding joints N, beyond the share of what is available at that speed."""
        loads, task = knots.loads, knots.task
        allowed = super().allowance(knots) * task.robot.torque_limit
        available = task.limits.torque_share * loads.torque_available
        excess: Array = np.abs(loads.joint_torque) - available - allowed
        return excess

    def checked_shares(self, knots: Knots) -> Array:
        speeds: Array = knots.loads.joint_velocity / knots.task.robot.speed_limit
        return super().checked_shares(knots) + speeds

    def share_of(self, knots: Knots) -> Array:
        return FALL / knots.task.limits.torque_share * super().share_of(knots)

    def allowance(self, knots: Knots) -> float:
        return FALL / knots.task.limits.torque_share * super().allowance(knots)


class JointSpeed(_DriveConstraint):
    """|q'| <= share q'_max, where joints are fast: in flight and right beside it."""

    name = "joint_speed"
    unit = "rad/s"
    load = "joint_velocity"
    allowances = SPEED_ALLOWANCE, COMPARED_SPEED_ALLOWANCE
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

    def share_of(self, knots: Knots) -> Array:
        share: Array = 1 / knots.task.robot.speed_limit
        return share

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


def _tamed(share: Any, root: Callable[[Any], Any] = ca.sqrt) -> Any:
    """A share, or its bound, as a row: increasing, and far beyond the limit ever slower."""
    return share / root(root(1 + (share / FAR_BEYOND) ** 2))


def _untamed(row: Array) -> Array:
    """The share that a row is of."""
    fourth = row**4
    square = fourth / FAR_BEYOND**2
    share: Array = np.sign(row) * np.sqrt((square + np.sqrt(square**2 + 4 * fourth)) / 2)
    return share


def _swings_on(knots: Knots) -> NDArray[np.bool_]:
    """(N, J) joints of legs that swing over an interval and the next one.

    Their rows are as an interval begins, the check is in its middle.
    """
    swings = ~knots.layout.standing[:-1]
    on = swings & np.vstack([swings[1:], np.zeros_like(swings[:1])])
    joints = np.zeros((len(on), knots.task.joints), dtype=bool)
    for leg, mine in enumerate(knots.task.robot.leg_joint_index):
        joints[:, mine] = on[:, [leg]]
    return joints


def _on_rows(amounts: Array, both: NDArray[np.bool_], larger: np.ufunc) -> Array:
    """(N+1, J) for the rows of amounts (N, J) over intervals; `both` belong to the next row too."""
    rows = np.vstack([amounts, np.zeros_like(amounts[:1])])
    rows[1:] = np.where(both, larger(rows[1:], amounts), rows[1:])
    return rows


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


DRIVES: tuple[_DriveConstraint, ...] = (JointTorque(), TorqueAtSpeed(), JointSpeed())
