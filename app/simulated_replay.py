"""A rollout turned into frames, beside those of the plan that it followed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.frames import FRAME_RATE, Frames, make_frames
from llsrbm.motion.plan import Phase
from llsrbm.motion.rollout import Rollout
from llsrbm.robots import Robot

Array = NDArray[np.float64]

_BASE = 7  # numbers of a free joint before the joints' in qpos


@dataclass(frozen=True, eq=False)
class SimulatedReplay:
    """A rollout, ready to be drawn.

    Attributes:
        rollout: where it comes from.
        frames: of the simulated robot, with the whole body's inertia; contact forces are means
            over a frame.
    """

    rollout: Rollout
    frames: Frames


def bake_rollout(rollout: Rollout, robot: Robot) -> SimulatedReplay:
    """All frames of a rollout; every frame is one of its ticks."""
    tick = float(np.diff(rollout.time[:2])[0]) if len(rollout.time) > 1 else 1 / FRAME_RATE
    stride = max(1, round(1 / (tick * FRAME_RATE)))
    # The last tick is drawn, whatever the stride: it is where the robot stands, or lies.
    kept = np.arange((len(rollout.time) - 1) % stride, len(rollout.time), stride)
    kept = np.union1d(kept, 0)
    names = list(rollout.joint_names)
    joints = [_BASE + names.index(name) for name in robot.joint_names]
    frames = make_frames(
        robot,
        time=rollout.time[kept],
        com=rollout.com[kept],
        base_position=rollout.base_position[kept],
        base_quat=rollout.base_quat[kept],
        joint_position=rollout.qpos[kept][:, joints],
        inertia=rollout.inertia[kept],
        foot_position=rollout.foot_position[kept],
        flight=(rollout.phase == Phase.FLIGHT)[kept],
        foot_force=means_from(rollout.contact_force, kept),
        # Where in a sole it acts is not recorded.
        pressed_at=rollout.foot_position[kept],
    )
    return SimulatedReplay(rollout, frames)


def means_from(values: Array, first: NDArray[np.int64]) -> Array:
    """Means of `values` (T, ...) over the stretches that begin at `first` (F,), increasing."""
    counts = np.diff(np.append(first, len(values)))
    sums = np.add.reduceat(values, first, axis=0)
    means: Array = sums / counts.reshape(-1, *([1] * (values.ndim - 1)))
    return means
