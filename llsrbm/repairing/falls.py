"""Flights as the CoM has them: in one it falls freely, whatever the feet are seen to do.

Feet of clips that were filmed slide while they stand and float while they do not, so that none
stays where it is. Gravity is in such clips all the same.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.signal import savgol_filter

from llsrbm.arrays import Array, stretches
from llsrbm.mechanics import GRAVITY
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.repairing.stances import crossing, noise

# Of the 52 clips of G1 that come with ASAP, in stretches in which no foot stays where it is: CoMs
# that jump fall with 6.1 to 11.3 m/s2, those of steps, kicks and dances with 4.0 at most.
FREELY = 0.45 * GRAVITY  # m/s2, at least, with which a CoM falls that falls freely
FITS = 0.005  # m, RMS, by which it is off a parabola then
SHORTEST = 0.08  # s for which it does
LOOK = 0.13  # s over which its acceleration is measured
RISE = 0.02  # m to which all feet rise at once of a body that flies, though it does not fall so
LOW = 0.04  # m above the lowest foot, at most, of one that stands as well
LASTS = 0.1  # s, at least, for which the same feet stand
OFF_FALL = 0.001  # m by which a CoM is off the parabola of a flight that has ended
INSIDE = 0.15  # of a flight at each end, which that parabola is not fitted to


def flights_within(motion: WholeBodyMotion, start: float, end: float) -> list[tuple[float, float]]:
    """When the robot flies, s, in a stretch in which no foot is seen to stand.

    All of it if the CoM falls as in one flight; else those parts of it in which it does. Where it
    nowhere does, as of a motion that is slowed down, all of it if all feet rise at once.
    """
    time, height = motion.time, motion.com[:, 2]
    if _is_parabola(time, height, start, end):
        return [(start, end)]
    parts = []
    for first, last in _falling(time, height, start, end):
        edges = fall_edges(time, height, first, last)
        parts.append((max(edges[0], start), min(edges[1], end)))
    if parts:
        return parts
    return [(start, end)] if _rises(motion, start, end) else []


def standing(motion: WholeBodyMotion, start: float, end: float) -> list[tuple[float, Array]]:
    """Which feet stand in a stretch without a flight: from when, s, and (L,) whether each does.

    The lowest one does, and those that are hardly higher.
    """
    time, height = motion.time, motion.foot_position[..., 2]
    frames = np.flatnonzero((time >= start) & (time < end))
    if not len(frames):
        frames = np.array([np.abs(time - (start + end) / 2).argmin()])
    low = height[frames] - height[frames].min(axis=1, keepdims=True) < LOW
    changes = np.flatnonzero((low[1:] != low[:-1]).any(axis=1)) + 1
    found = [(start, low[0])]
    for first, last in pairwise([0, *changes.tolist(), len(frames)]):
        if first and (time[frames[last - 1]] - time[frames[first]] >= LASTS):
            found.append((float(time[frames[first]]), low[first]))
    return found


def fall_edges(time: Array, height: Array, start: float, end: float) -> tuple[float, float]:
    """From when to when, s, a CoM is on the parabola on which it is within a flight."""
    long = end - start
    for share in (INSIDE, 0.0):
        inside = np.flatnonzero((time > start + share * long) & (time < end - share * long))
        if len(inside) >= 4:
            break
    else:
        return start, end
    curve = np.polyfit(time[inside] - start, height[inside], 2)
    away = np.abs(height - np.polyval(curve, time - start))
    off = OFF_FALL + 3 * noise(height)
    first, last = int(inside[0]), int(inside[-1])
    return crossing(time, away, off, first, -1), crossing(time, away, off, last, 1)


def _is_parabola(time: Array, height: Array, start: float, end: float) -> bool:
    inner = INSIDE * (end - start)
    inside = (time > start + inner) & (time < end - inner)
    if inside.sum() < 4:
        return False
    since, own = time[inside] - start, height[inside]
    curve = np.polyfit(since, own, 2)
    off = float(np.sqrt(np.mean((np.polyval(curve, since) - own) ** 2)))
    return bool(-2 * curve[0] >= FREELY and off <= FITS + noise(height))


def _falling(time: Array, height: Array, start: float, end: float) -> list[tuple[float, float]]:
    """Where a CoM's acceleration is that of a fall, s, within a stretch."""
    step = float(np.median(np.diff(time)))
    over = max(round(LOOK / step) | 1, 5)
    if len(time) < over:
        return []
    acceleration = savgol_filter(height, over, 2, deriv=2, delta=step)
    falls = (acceleration <= -FREELY) & (time >= start) & (time <= end)
    found = [(float(time[first]), float(time[last - 1])) for first, last in stretches(falls)]
    return [(first, last) for first, last in found if last - first >= SHORTEST]


def _rises(motion: WholeBodyMotion, start: float, end: float) -> bool:
    """Whether all feet are at once above where they are at the ends of a stretch."""
    time, height = motion.time, motion.foot_position[..., 2]
    inside = (time > start) & (time < end)
    if not inside.any():
        return False
    ends = np.array([[np.interp(at, time, foot) for foot in height.T] for at in (start, end)])
    share = ((time[inside] - start) / (end - start))[:, None]
    line = ends[0] + share * (ends[1] - ends[0])
    return bool((height[inside] - line).min(axis=1).max() >= RISE)
