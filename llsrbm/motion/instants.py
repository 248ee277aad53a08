"""At which instants a motion is sampled: evenly, and exactly where its contacts change."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import InputError
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout

Array = NDArray[np.float64]

FASTEST = 10_000.0  # frames/s; more is a mistyped number
LONGEST_PAD = 60.0  # s, likewise
_SAME_INSTANT = 1e-9  # s


def events(trajectory: Plan | Rollout) -> Array:
    """First and last instant, and those between at which something changes at once, s.

    Of a plan the edges of its phases, at which feet leave the ground or meet it; of a rollout the
    ticks at which the controller changes phase or mode, and those in which a foot leaves the ground
    or meets it.
    """
    if isinstance(trajectory, Plan):
        return trajectory.phase_start
    states = np.column_stack([trajectory.phase, trajectory.mode, trajectory.contact])
    changed = np.flatnonzero((np.diff(states, axis=0) != 0).any(axis=1)) + 1
    ticks = np.unique(np.concatenate([[0], changed, [len(trajectory.time) - 1]]))
    return trajectory.time[ticks]


def with_events(trajectory: Plan | Rollout, fps: float) -> Array:
    """Instants 1/fps apart from the first to the last, and every event, in order, s.

    Raises:
        InputError: `fps` is not a positive number up to 10000.
    """
    check_rate(fps)
    exact = events(trajectory)
    start, end = exact[0], exact[-1]
    times = start + np.arange(math.floor((end - start) * fps) + 1) / fps
    after = np.clip(np.searchsorted(exact, times), 1, len(exact) - 1)
    nearest = np.minimum(np.abs(times - exact[after - 1]), np.abs(times - exact[after]))
    apart = nearest > _SAME_INSTANT
    return np.unique(np.concatenate([times[apart], exact]))


def evenly(trajectory: Plan | Rollout, fps: float, pad: float = 0.0) -> Array:
    """Instants exactly 1/fps apart that hold the whole motion, s of the motion's own time.

    Args:
        trajectory: what is sampled.
        fps: instants/s.
        pad: s of standing still before the motion and after it, rounded up to whole frames.

    Raises:
        InputError: `fps` is not a positive number up to 10000, or `pad` not one from 0 to 60 s.
    """
    check_rate(fps)
    if not (math.isfinite(pad) and 0 <= pad <= LONGEST_PAD):
        raise InputError(f"pad: expected 0 to {LONGEST_PAD:g} s of standing still, got {pad}")
    start, end = trajectory.time[[0, -1]]
    still = math.ceil(pad * fps - _SAME_INSTANT)
    moving = math.ceil((end - start) * fps - 1e-6)
    times: Array = start + np.arange(-still, moving + still + 1) / fps
    return times


def check_rate(fps: float) -> None:
    """Raise `InputError` unless `fps` is a rate at which something can be sampled."""
    if not (math.isfinite(fps) and 0 < fps <= FASTEST):
        raise InputError(f"frames per second: expected 0 < fps <= {FASTEST:.0f}, got {fps}")
