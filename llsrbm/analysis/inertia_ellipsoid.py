"""An inertia as something to look at: the uniform solid of the same mass and inertia."""

import numpy as np
from scipy.spatial.transform import Rotation

from llsrbm.arrays import Array, IntArray


def ellipsoid(inertia: Array, mass: float, reference: Array) -> tuple[Array, Array]:
    """The uniform solid ellipsoid of this mass (kg) and inertia (K, 3, 3) kg m2.

    Its principal moments are I_i = m/5 (a_j^2 + a_k^2), so a_i = sqrt(5/(2m) (I_j + I_k - I_i)).
    Axis i is the one that lies near column i of `reference` (K, 3, 3), rotations, or its wireframe
    would jump whenever two moments cross. Returns semi-axes (K, 3) m and attitude (K, 4) w, x, y,
    z.
    """
    moments, axes = np.linalg.eigh(inertia)
    likeness = np.abs(np.einsum("kji,kjl->kil", np.broadcast_to(reference, axes.shape), axes))
    order = _assignment(likeness)
    moments = np.take_along_axis(moments, order, axis=1)
    axes = np.take_along_axis(axes, order[:, None, :], axis=2)
    sign = np.sign(np.einsum("kji,kji->ki", np.broadcast_to(reference, axes.shape), axes))
    axes = axes * np.where(sign == 0, 1.0, sign)[:, None, :]
    axes[:, :, 2] *= np.sign(np.linalg.det(axes))[:, None]
    squares = 5 / (2 * mass) * (moments.sum(axis=1, keepdims=True) - 2 * moments)
    quaternion = Rotation.from_matrix(axes).as_quat(scalar_first=True)
    # A point mass model may violate the triangle inequality of moments by rounding.
    return np.sqrt(np.maximum(squares, 1e-6)), quaternion


_PERMUTATIONS = np.array([[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]])


def _assignment(likeness: Array) -> IntArray:
    """(K, 3): the permutation with the largest sum of likeness[k, i, order[i]]."""
    total = likeness[:, [0, 1, 2], _PERMUTATIONS].sum(axis=-1)
    return _PERMUTATIONS[np.argmax(total, axis=1)]
