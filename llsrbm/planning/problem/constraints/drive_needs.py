"""The drive that stops a jump: which joint needs how much of what it has, and when."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from llsrbm.arrays import Array
from llsrbm.body.joint_loads import JointLoads
from llsrbm.body.peak_loads import event_beside, when_in_words
from llsrbm.errors import JointNeed
from llsrbm.planning.problem.constraints.base import JointDemand
from llsrbm.planning.problem.constraints.drive_shares import MIDDLE, Place, of_planned
from llsrbm.planning.problem.knots import Knots

if TYPE_CHECKING:
    from llsrbm.planning.problem.constraints.drive_rows import DriveConstraint

_OF_SLIDING = {"Nm": "N", "rad/s": "m/s"}


def largest_demand(constraint: DriveConstraint, knots: Knots) -> JointDemand | None:
    """The largest demand beyond what a joint may use, as shares of limits; None: there is none."""
    needed = constraint.needed(knots)
    has = constraint.allowed(knots, constraint.share(knots.task))
    excess = of_planned((needed - has) * constraint.share_of(knots), knots)
    if np.isnan(excess[:, MIDDLE]).any() or not 0 < np.nanmax(excess) < np.inf:
        return None  # nothing is exceeded, or by no number
    place = _place(excess)
    return JointDemand(_need(constraint, knots, place, needed[place], has[place]), place[0])


def leaning_joint(
    constraint: DriveConstraint, knots: Knots, knot: int, value: float
) -> JointNeed | None:
    """The joint with the largest share at or after a knot, and what it may use under `value`."""
    interval = min(knot, len(knots.dt) - 1)
    shares = np.abs(constraint.checked_shares(knots)[[interval]])
    shares = shares / constraint.tops(knots.task)[:, None]
    if np.isnan(shares).all():
        return None
    place = interval, *_place(shares)[1:]
    has = constraint.allowed(knots, value)[place]
    return _need(constraint, knots, place, has, has)


def _place(values: Array) -> Place:
    """Where the largest of (N, 2, J) is."""
    interval, where, joint = np.unravel_index(np.nanargmax(values), values.shape)
    return int(interval), int(where), int(joint)


def _need(
    constraint: DriveConstraint, knots: Knots, place: Place, needed: float, has: float
) -> JointNeed:
    robot, (interval, _, joint) = knots.task.robot, place
    name, unit = robot.joint_names[joint], constraint.unit
    unit = _OF_SLIDING[unit] if name in robot.sliding_joints else unit
    return JointNeed(name, needed, has, unit, when_in(knots.loads, interval))


def when_in(loads: JointLoads, interval: int) -> str:
    """An interval, in words."""
    phase = loads.schedule[int(loads.phase[interval])].name
    return when_in_words(phase, loads.time[interval], event_beside(loads.contact, interval))
