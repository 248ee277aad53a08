"""Rigid-body arithmetic over leading dimensions: vectors, rotations, gravity.

Quaternions are w, x, y, z.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from llsrbm.arrays import Array

GRAVITY = 9.81
"""Acceleration of free fall, m/s2, along -z of the world."""

INSCRIBED = 0.5**0.5
"""Share of a friction cone's coefficient that the four-sided pyramid inside the cone has.

A pyramid with the cone's own coefficient reaches out of the cone at its edges, where feet slip.
"""

CORNERS: Array = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
"""(8, 3) corners of a cube from 0 to 1."""

_NEXT, _AFTER_NEXT = [1, 2, 0], [2, 0, 1]


def cross(a: Array, b: Array) -> Array:
    """Cross product of the last axis; far quicker than `numpy.cross` on short vectors."""
    return a[..., _NEXT] * b[..., _AFTER_NEXT] - a[..., _AFTER_NEXT] * b[..., _NEXT]


def skew(a: Array) -> Array:
    """Matrix S (..., 3, 3) with S b = a x b, of a (..., 3)."""
    x, y, z = np.moveaxis(a, -1, 0)
    zero = np.zeros_like(x)
    rows = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1)
    return rows.reshape(*a.shape, 3)


def apply(matrix: Array, vector: Array) -> Array:
    """Matrix times vector over leading dimensions: (..., r, k), (..., k) -> (..., r)."""
    return (matrix @ vector[..., None])[..., 0]


def turns_about_z(angle: ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3) of angles (...) rad about z."""
    rotation = np.zeros((*np.shape(angle), 3, 3))
    rotation[..., 0, 0] = rotation[..., 1, 1] = np.cos(angle)
    rotation[..., 1, 0] = np.sin(angle)
    rotation[..., 0, 1] = -rotation[..., 1, 0]
    rotation[..., 2, 2] = 1.0
    return rotation


def quaternions_about_z(angle: ArrayLike) -> Array:
    """Unit quaternions w, x, y, z (..., 4) of angles (...) rad about z."""
    half = np.asarray(angle) / 2
    zero = np.zeros_like(half)
    return np.stack([np.cos(half), zero, zero, np.sin(half)], axis=-1)


def quaternion_product(a: Array, b: Array) -> Array:
    """Hamilton product a o b of quaternions w, x, y, z (..., 4): the turn b, then a."""
    vector = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + cross(a[..., 1:], b[..., 1:])
    scalar = a[..., :1] * b[..., :1] - (a[..., 1:] * b[..., 1:]).sum(axis=-1, keepdims=True)
    return np.concatenate([scalar, vector], axis=-1)


def rotation_matrices(quat: ArrayLike) -> Array:
    """Unit or nearly unit quaternions w, x, y, z (..., 4) as rotation matrices (..., 3, 3)."""
    q = np.asarray(quat, dtype=float)
    w, x, y, z = np.moveaxis(q / np.linalg.norm(q, axis=-1, keepdims=True), -1, 0)
    rows = [
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
    ]  # fmt: skip
    return np.stack(rows, axis=-1).reshape(*q.shape[:-1], 3, 3)


def quaternions(rotation: Array) -> Array:
    """Rotation matrices (..., 3, 3) as unit quaternions w, x, y, z (..., 4)."""
    flat = Rotation.from_matrix(rotation.reshape(-1, 3, 3)).as_quat(scalar_first=True)
    return flat.reshape(*rotation.shape[:-2], 4)


def turned_to(along: Array, axis: int) -> Array:
    """Quaternions w, x, y, z (..., 4) that turn an axis, 0 to 2, to `along` (..., 3).

    The short way; none where there is no length.
    """
    own, length = np.eye(3)[axis], np.linalg.norm(along, axis=-1, keepdims=True)
    unit = np.where(length > 0, along / np.where(length > 0, length, 1.0), own)
    wxyz = np.concatenate([1 + unit[..., axis, None], cross(own, unit)], axis=-1)
    # Straight back, any half turn about an axis across.
    wxyz[unit[..., axis] < -1 + 1e-9] = [0.0, *np.eye(3)[2 - axis]]
    return wxyz / np.linalg.norm(wxyz, axis=-1, keepdims=True)


def rotation_vectors(rotation: Array) -> Array:
    """Rotation vectors (..., 3) rad of matrices (..., 3, 3), the shorter way; NaN of what is none.

    SciPy raises at numbers such as a solver that diverges leaves.
    """
    flat = rotation.reshape(-1, 3, 3)
    known = np.isfinite(flat).all(axis=(1, 2))
    vectors = np.full((len(flat), 3), np.nan)
    vectors[known] = Rotation.from_matrix(flat[known]).as_rotvec()
    return vectors.reshape(*rotation.shape[:-2], 3)


def turns_between(start: Array, end: Array, *, body_axes: bool = False) -> Array:
    """Rotation vectors (..., 3) rad from attitudes (..., 4) to others, the shorter way.

    In world axes or the body's; NaN where an attitude is none, as of `rotation_vectors`.
    """
    pairs = np.concatenate([start, end], axis=-1).reshape(-1, 8)
    known = np.isfinite(pairs).all(axis=1) & pairs[:, :4].any(axis=1) & pairs[:, 4:].any(axis=1)
    first, last = (
        Rotation.from_quat(pairs[known, half], scalar_first=True)
        for half in (slice(0, 4), slice(4, 8))
    )
    vectors = np.full((len(pairs), 3), np.nan)
    vectors[known] = (first.inv() * last if body_axes else last * first.inv()).as_rotvec()
    return vectors.reshape(*start.shape[:-1], 3)


def interpolated(time: Array | float, known: Array, values: Array) -> Array:
    """Values (K, ...) at `time` (K,), or (...) at one time, straight between those at `known`.

    `known`: (N,); `values`: (N, ...), of which the first and the last hold beyond them.
    """
    flat = values.reshape(len(known), -1)
    found = np.stack([np.interp(time, known, column) for column in flat.T], axis=-1)
    return found.reshape(*np.shape(time), *values.shape[1:])


def sign_continuous(quat: Array) -> Array:
    """The same attitudes, signed such that neighbours in time (axis 0) are close, (K, ..., 4)."""
    if len(quat) < 2:
        return quat
    flip = np.sum(quat[1:] * quat[:-1], axis=-1) < 0
    sign = np.cumprod(np.where(flip, -1.0, 1.0), axis=0)
    return np.concatenate([quat[:1], quat[1:] * sign[..., None]])


def slerp(start: Array, end: Array, share: Array) -> Array:
    """Attitudes (..., 4) at shares, broadcastable to (...), of the shorter way to `end`."""
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
    return quat / np.linalg.norm(quat, axis=-1, keepdims=True)


def yaw(quat: Array) -> Array:
    """Heading of a body's x axis seen from above, (K, 4) -> (K,) rad, continuous over time."""
    w, x, y, z = np.moveaxis(quat, -1, 0)
    return np.unwrap(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def final_yaw(time: Array, quat: Array, yaw_rate: Array) -> float:
    """Heading at the end, rad, whole turns counted, of a body (K, 4) that may turn over on its way.

    While its x axis is upright a body has no heading, so of one that turns over the number of whole
    turns is that of `yaw_rate` (K,) rad/s, its angular velocity about the world's z.
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
    return 2 * np.arcsin(np.minimum(np.hypot(x, y), 1.0))


_UPRIGHT = np.radians(45.0)  # tilt up to which a base has a heading


def turned(actual: Array, planned: Array) -> Array:
    """(T,) rad by which attitudes (T, 4) are turned about the vertical from the planned ones.

    Far from upright, where a heading means nothing, the vertical part of the turn between them.
    """
    turn = (yaw(actual) - yaw(planned) + np.pi) % (2 * np.pi) - np.pi
    far = np.maximum(tilt(actual), tilt(planned)) > _UPRIGHT
    if far.any():
        between = Rotation.from_quat(actual[far], scalar_first=True)
        between = between * Rotation.from_quat(planned[far], scalar_first=True).inv()
        turn[far] = between.as_rotvec()[:, 2]
    return np.asarray(turn)
