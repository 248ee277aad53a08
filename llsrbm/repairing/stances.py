"""When and where feet stand: where they stay for a while, told from how they move.

Heights are crossed between frames, not at them. A foot counts by how far it is from where it stood,
not from the ground, so that motions that float or sink have places all the same.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from llsrbm.arrays import Array, stretches
from llsrbm.motion.whole_body import WholeBodyMotion

STILL_FOR = 0.2  # s for which a foot stays where it is that stands; at the top of a flight it moves
STILL = 0.006  # m, standard deviation of its places over that time
# m by which a foot is off where it stands as it leaves and as it comes. With it and the CoM's fall,
# edges of flights of 12 simulated jumps of Go2, ANYmal and G1 are at most 17 ms off, at 30, 50 and
# 100 frames/s, with joints that are off by 0.01 rad and without.
OFF = 0.006
SAME = 0.03  # m that a foot slips where it stands
NOISE = 2.0  # standard deviations of what each frame is off by that count as being off
NOISIEST = 0.03  # m by which each frame is off, at most, of a foot that may be seen to stand
LIFTS = 0.01  # s, at most, for which a foot has been leaving that is so far off


class Stance(NamedTuple):
    """A foot that stands: when, s, and where, (3,) m, the median of its contact point's places."""

    start: float
    end: float
    place: Array


def stances(motion: WholeBodyMotion, foot: int) -> list[Stance]:
    """When and where a foot stands, in order."""
    time, place = motion.time, motion.foot_position[:, foot]
    off = OFF + NOISE * noise(place[:, 2])
    found: list[Stance] = []
    for first, end in _still(time, place):
        # It is still until it has moved, so it has begun to at the end of that.
        half = max((_last_within(time, first) - first) // 2, 0)
        inside = slice(first + half, max(end - half, first + half + 1))
        at = np.median(place[inside], axis=0)
        came = np.abs(place[:, 2] - np.median(place[inside][: 2 * half + 1, 2]))
        leaves = np.abs(place[:, 2] - np.median(place[inside][-2 * half - 1 :, 2]))
        start = crossing(time, came, off, inside.start, -1)
        # It has begun to leave before; by half of this lift-offs of simulated jumps are met.
        stop, higher = (crossing(time, leaves, k * off, inside.stop - 1, 1) for k in (1, 4))
        if stop < time[-1]:
            stop -= min((higher - stop) / 2, LIFTS)
        if found and start <= found[-1].end:
            last = found[-1]
            if np.linalg.norm(last.place - at) < SAME:
                found[-1] = last._replace(end=max(stop, last.end))
                continue
            start = (start + last.end) / 2  # it has slid there
            found[-1] = last._replace(end=start)
        found.append(Stance(start, stop, at))
    return found


def noise(values: Array) -> float:
    """The standard deviation by which each frame of a smooth quantity (K,) is off.

    By its third differences, which motions hardly have.
    """
    if len(values) < 8:
        return 0.0
    third = np.diff(values, 3)
    return float(np.median(np.abs(third)) / 0.6745 / np.sqrt(20.0))


def _still(time: Array, place: Array) -> list[tuple[int, int]]:
    """[first, end) of frames among which a foot hardly moves for `STILL_FOR`."""
    off = np.minimum([noise(axis) for axis in place.T], NOISIEST)
    spread = np.sqrt(STILL**2 + off**2)
    still = np.zeros(len(time), dtype=np.bool_)
    for k in range(len(time)):
        end = _last_within(time, k) + 1
        if (
            time[end - 1] - time[k] > 0.8 * STILL_FOR
            and (np.std(place[k:end], axis=0) < spread).all()
        ):
            still[k:end] = True
    return stretches(still)


def _last_within(time: Array, k: int) -> int:
    """The last frame within `STILL_FOR` after one."""
    return int(np.searchsorted(time, time[k] + STILL_FOR + 1e-9)) - 1


def crossing(time: Array, away: Array, off: float, at: int, step: int) -> float:
    """When, going on from a frame, a foot is first off its place, s; the motion's end if never."""
    # A single frame that is off is wrong.
    while (
        0 <= at + step < len(time) and away[[at + step, _within(at + 2 * step, time)]].min() <= off
    ):
        at += step
    if not 0 <= at + step < len(time):
        return float(time[at])
    here, there = away[at], away[at + step]
    share = (off - here) / max(there - here, 1e-12)
    return float(time[at] + np.clip(share, 0.0, 1.0) * (time[at + step] - time[at]))


def _within(at: int, time: Array) -> int:
    return min(max(at, 0), len(time) - 1)
