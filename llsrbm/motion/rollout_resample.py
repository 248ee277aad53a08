"""A rollout at any time, from its ticks: states move evenly, what is held for a tick is held."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import InputError
from llsrbm.motion.resample import frame_times
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.rotation import sign_continuous, slerp

Array = NDArray[np.float64]

_SAME_INSTANT = 1e-9  # s; a time that rounding puts before its tick belongs to the tick

_MOVING = (
    "qvel",
    "com",
    "base_position",
    "linear_momentum",
    "angular_momentum",
    "inertia",
    "foot_position",
    "average_spatial_velocity_norm",
    "reference_com",
    "reference_foot_position",
    "reference_angular_momentum",
)
_TURNING = ("base_quat", "reference_base_quat")
_HELD = (
    "torque",
    "torque_limit",
    "contact",
    "contact_force",
    "detection_signal",
    "mode",
    "phase",
)


def rollout_times(rollout: Rollout, fps: float) -> Array:
    """Instants 1/fps apart from first tick to last, both included, and every tick that matters.

    Those are the ticks at which the controller changes phase or mode, and those in which the robot
    leaves the ground or meets it.

    Raises:
        InputError: `fps` is not a positive number up to 10000.
    """
    standing = rollout.contact.any(axis=1).astype(np.int64)
    states = np.stack([rollout.phase, rollout.mode, standing])
    changed = np.flatnonzero((np.diff(states, axis=1) != 0).any(axis=0)) + 1
    ticks = np.unique(np.concatenate([[0], changed, [len(rollout.time) - 1]]))
    return frame_times(rollout.time[ticks], fps)


def resample_rollout(rollout: Rollout, times: Array) -> Rollout:
    """The rollout with instants `times` (K,) s in place of its ticks.

    Between ticks states are linear, attitudes turn evenly; torques, forces and flags are those of
    the tick that holds the instant. Ticks are reproduced exactly. Quaternions come out without
    jumps of sign. Before the first tick and after the last nothing changes.

    Raises:
        InputError: a time is not finite.
    """
    times = np.atleast_1d(np.asarray(times, dtype=np.float64))
    if times.ndim != 1 or not np.isfinite(times).all():
        raise InputError("times: expected a list of finite numbers, s")
    ticks = rollout.time
    inside = np.clip(times, ticks[0], ticks[-1])
    tick = np.searchsorted(ticks, inside + _SAME_INSTANT, side="right") - 1
    left = np.minimum(tick, len(ticks) - 2)
    share = np.clip((inside - ticks[left]) / np.diff(ticks)[left], 0.0, 1.0)

    def even(values: Array) -> Array:
        portion = share.reshape(-1, *[1] * (values.ndim - 1))
        mixed: Array = (1 - portion) * values[left] + portion * values[left + 1]
        return mixed

    def turned(quat: Array) -> Array:
        quat = sign_continuous(quat)
        return slerp(quat[left], quat[left + 1], share)

    values: dict[str, Any] = {name: even(getattr(rollout, name)) for name in _MOVING}
    values |= {name: turned(getattr(rollout, name)) for name in _TURNING}
    values |= {name: getattr(rollout, name)[tick] for name in _HELD}
    values["qpos"] = even(rollout.qpos)
    values["qpos"][:, 3:7] = turned(rollout.qpos[:, 3:7])
    return replace(rollout, time=times, **values)
