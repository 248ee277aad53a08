"""A rollout turned into frames, beside those of the plan that it followed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from app.motion.frames import FRAME_RATE, Frames, make_frames
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.whole_body import motion_at_ticks

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SimulatedMotion:
    """A rollout, ready to be drawn.

    Attributes:
        rollout: where it comes from.
        frames: of the simulated robot, with the whole body's inertia; contact forces are means
            over a frame.
    """

    rollout: Rollout
    frames: Frames


def bake_rollout(rollout: Rollout) -> SimulatedMotion:
    """All frames of a rollout; every frame is one of its ticks."""
    tick = float(np.diff(rollout.time[:2])[0]) if len(rollout.time) > 1 else 1 / FRAME_RATE
    stride = max(1, round(1 / (tick * FRAME_RATE)))
    # The last tick is drawn, whatever the stride: it is where the robot stands, or lies.
    kept = np.arange((len(rollout.time) - 1) % stride, len(rollout.time), stride)
    kept = np.union1d(kept, 0)
    motion = motion_at_ticks(rollout, kept)
    motion = replace(motion, foot_force=means_from(rollout.contact_force, kept))
    return SimulatedMotion(rollout, make_frames(motion, rollout.schedule))


def means_from(values: Array, first: NDArray[np.int64]) -> Array:
    """Means of `values` (T, ...) over the stretches that begin at `first` (F,), increasing."""
    counts = np.diff(np.append(first, len(values)))
    sums = np.add.reduceat(values, first, axis=0)
    means: Array = sums / counts.reshape(-1, *([1] * (values.ndim - 1)))
    return means
