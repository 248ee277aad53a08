"""A clip put together again: repaired jumps in their places, led into by the frames beside them.

Frames beside a jump are the clip's own, except next to it, where they lead over to the plan's
posture at rest. Frames after a jump go where it leads: they are turned about the vertical and
shifted so that their feet are where the plan's have landed, and come as much later as the plan
lasts longer, rounded up to a frame, in which the robot stands still.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from llsrbm.arrays import Array
from llsrbm.motion.plan import Plan
from llsrbm.motion.whole_body import (
    WholeBodyMotion,
    motion_of_states,
    velocities,
    whole_body_motion,
)
from llsrbm.repairing.crossfade import crossfaded
from llsrbm.repairing.feet import feet_of
from llsrbm.repairing.frame import Frame, frame_between
from llsrbm.repairing.request import Request
from llsrbm.robots.robot import Robot

LASTS = 0.3  # s of a join


class Join(NamedTuple):
    """A stretch of a repaired clip that leads from its own frames to a plan or back.

    `start_s`, `end_s`: s of the repaired clip's time, from the last frame before it to the first
    after; `feet_m`: the most that a foot moves in it which stands all the time.
    """

    start_s: float
    end_s: float
    feet_m: float


class Joined(NamedTuple):
    """A whole clip, with the times (start, end) s of its plans in it, and its joins, in order."""

    motion: WholeBodyMotion
    plans: tuple[tuple[float, float], ...]
    joins: tuple[Join, ...]


class _States(NamedTuple):
    """K frames in MuJoCo's convention; `led`: those of a join."""

    qpos: Array
    qvel: Array
    led: Array

    @staticmethod
    def of(motion: WholeBodyMotion) -> _States:
        """Those of a motion."""
        return _States(motion.qpos, motion.qvel, np.zeros(len(motion.time), dtype=np.bool_))

    def between(self, begin: int, end: int) -> _States:
        """Frames from one up to another; none where that is before it."""
        own = slice(begin, max(begin, end))
        return _States(self.qpos[own], self.qvel[own], self.led[own])

    def seen_from(self, frame: Frame) -> _States:
        """The states, which are in a frame, in its outer frame."""
        place = frame.back(self.qpos[:, :3]), frame.attitudes_back(self.qpos[:, 3:7])
        qvel = np.hstack([frame.turned_back(self.qvel[:, :3]), self.qvel[:, 3:]])
        return self._replace(qpos=np.hstack([*place, self.qpos[:, 7:]]), qvel=qvel)


def joined(clip: WholeBodyMotion, repaired: Sequence[tuple[Request, Plan]]) -> Joined:
    """The clip with plans in place of the jumps that they were made of, at its own rate.

    `clip`: of evenly spaced frames; `repaired`: in order.
    """
    assert clip.fps is not None
    beside, plans = _placed(clip, repaired)
    rows: list[_States] = []
    times, count = [], 0
    for k, own in enumerate(beside):
        before = plans[k - 1].qpos[-1] if k else None
        after = plans[k].qpos[0] if k < len(plans) else None
        led = _led(clip.robot, round(LASTS * clip.fps), own, before, after)
        rows += [led, *plans[k : k + 1]]
        if k < len(plans):
            start = count + len(led.qpos)
            count = start + len(plans[k].qpos)
            times.append((start / clip.fps, (count - 1) / clip.fps))
    qpos, qvel, joins = (np.concatenate(each) for each in zip(*rows, strict=True))
    time = np.arange(len(qpos)) / clip.fps
    qvel = np.where(joins[:, None], velocities(time, qpos), qvel)
    motion = motion_of_states(clip.robot, clip.origin, time, qpos, qvel, clip.fps)
    return Joined(motion, tuple(times), tuple(_joins(motion, joins)))


def _placed(
    clip: WholeBodyMotion, repaired: Sequence[tuple[Request, Plan]]
) -> tuple[list[_States], list[_States]]:
    """The frames beside the plans, in one stretch more, and the plans, all in their places."""
    assert clip.fps is not None
    whole = _States.of(clip)
    beside, plans = [], []
    frame, begin = Frame(0.0, np.zeros(3)), 0
    for request, plan in repaired:
        first, last = np.round(request.part.edges[[0, -1]] * clip.fps).astype(int)
        beside.append(whole.between(begin, first).seen_from(frame))
        here = frame.after(request.frame)
        own = whole_body_motion(plan, clip.fps)
        plans.append(_States.of(own).seen_from(here))
        landed = feet_of(clip.robot, plans[-1].qpos[-1:])[0][0]
        frame, begin = frame_between(request.part.footholds()[-1], landed), int(last) + 1
    beside.append(whole.between(begin, len(clip.time)).seen_from(frame))
    return beside, plans


def _led(
    robot: Robot, lasts: int, own: _States, before: Array | None, after: Array | None
) -> _States:
    """A stretch of the clip led from a plan's last posture (7 + J,) and to a plan's first one.

    `lasts`: frames of a join. A stretch that is shorter than its joins is replaced by one move from
    what is before it to what is after it, that lasts as long as a join at least.
    """
    count, ends = len(own.qpos), (before is not None) + (after is not None)
    if not ends or (not count and ends == 1):
        return own
    if count < ends * lasts:
        return _moved_over(robot, max(count, lasts), own, before, after)
    qpos, led = own.qpos.copy(), own.led.copy()
    shares = np.arange(1, lasts + 1) / (lasts + 1)
    if before is not None:
        goal = np.broadcast_to(before, (lasts, len(before)))
        qpos[:lasts] = crossfaded(robot, goal, qpos[:lasts], shares)
        led[:lasts] = True
    if after is not None:
        goal = np.broadcast_to(after, (lasts, len(after)))
        qpos[-lasts:] = crossfaded(robot, qpos[-lasts:], goal, shares)
        led[-lasts:] = True
    return own._replace(qpos=qpos, led=led)


def _moved_over(
    robot: Robot, count: int, own: _States, before: Array | None, after: Array | None
) -> _States:
    """So many frames from one posture to another, at rest in both; the clip's own at its ends."""
    start = own.qpos[0] if before is None else before
    end = own.qpos[-1] if after is None else after
    first, last = int(before is not None), count + int(before is not None and after is not None)
    shares = (np.arange(count) + first) / last
    here, there = (np.broadcast_to(pose, (count, len(pose))) for pose in (start, end))
    qpos = crossfaded(robot, here, there, shares)
    return _States(qpos, np.zeros((count, len(start) - 1)), np.ones(count, dtype=np.bool_))


def _joins(motion: WholeBodyMotion, led: Array) -> list[Join]:
    found = []
    edges = np.flatnonzero(np.diff(np.concatenate([[False], led, [False]]).astype(int)))
    for first, end in edges.reshape(-1, 2):
        there = slice(max(first - 1, 0), min(end + 1, len(led)))
        feet, stands = motion.foot_position[there], motion.contact[there].all(axis=0)
        ways = np.linalg.norm(feet - feet[:1], axis=-1).max(axis=0)[stands]
        time = motion.time[there]
        found.append(Join(float(time[0]), float(time[-1]), float(ways.max(initial=0.0))))
    return found
