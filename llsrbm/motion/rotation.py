"""Quaternions (w, x, y, z) over time, in NumPy: K of them at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def rotation_matrices(quat: Array) -> Array:
    """R of unit quaternions, (..., 4) -> (..., 3, 3)."""
    w, x, y, z = np.moveaxis(quat, -1, 0)
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], axis=-1),
            np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=-1),
            np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=-1),
        ],
        axis=-2,
    )


def sign_continuous(quat: Array) -> Array:
    """The same attitudes, signed such that neighbours in time (axis 0) are close, (K, ..., 4)."""
    if len(quat) < 2:
        return quat
    flip = np.sum(quat[1:] * quat[:-1], axis=-1) < 0
    sign = np.cumprod(np.where(flip, -1.0, 1.0), axis=0)
    return np.concatenate([quat[:1], quat[1:] * sign[..., None]])


def slerp(start: Array, end: Array, share: Array) -> Array:
    """Attitudes `share` (broadcastable to (...)) of the way from `start` to `end`, (..., 4).

    The angular velocity along the way is constant. Of the two arcs the shorter one is taken.
    """
    dot = np.sum(start * end, axis=-1)
    end = np.where((dot < 0)[..., None], -end, end)
    # atan2 of chords is exact for small angles, where acos loses half the digits.
    angle = 2 * np.arctan2(
        np.linalg.norm(end - start, axis=-1), np.linalg.norm(end + start, axis=-1)
    )
    sine = np.sin(angle)
    tiny = sine < 1e-9
    safe = np.where(tiny, 1.0, sine)
    a = np.where(tiny, 1 - share, np.sin((1 - share) * angle) / safe)
    b = np.where(tiny, share, np.sin(share * angle) / safe)
    quat = a[..., None] * start + b[..., None] * end
    unit: Array = quat / np.linalg.norm(quat, axis=-1, keepdims=True)
    return unit


def yaw(quat: Array) -> Array:
    """Heading of a body's x axis seen from above, (K, 4) -> (K,) rad, continuous over time.

    Continuous, so that a half turn keeps its sign.
    """
    w, x, y, z = np.moveaxis(quat, -1, 0)
    heading: Array = np.unwrap(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
    return heading


def final_yaw(time: Array, quat: Array, yaw_rate: Array) -> float:
    """Heading at the end, rad, whole turns counted, of a body that may turn over on its way.

    While its x axis is upright a body has no heading, so of one that turns over the number of whole
    turns is that of its rate about the vertical.

    Args:
        time: (K,) s; quat: (K, 4).
        yaw_rate: (K,) rad/s, angular velocity about the world's z.
    """
    heading = yaw(quat)
    if tilt(quat).max() < np.pi / 2:
        return float(heading[-1])
    turned = float(np.sum(np.diff(time) * (yaw_rate[1:] + yaw_rate[:-1]) / 2))
    return float(heading[-1] + 2 * np.pi * np.round((turned - heading[-1]) / (2 * np.pi)))


def tilt(quat: Array) -> Array:
    """Angle between a body's z axis and the vertical, (..., 4) -> (...) rad."""
    _, x, y, _ = np.moveaxis(quat, -1, 0)
    # The half angle's sine is exact where the cosine of a small tilt has lost its digits.
    angle: Array = 2 * np.arcsin(np.minimum(np.hypot(x, y), 1.0))
    return angle
