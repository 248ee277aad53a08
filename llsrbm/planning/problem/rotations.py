"""Rotations for the planner's expressions; quaternions are w, x, y, z."""

from __future__ import annotations

from typing import Any

import casadi as ca


def rotation_matrix(quat: Any) -> Any:
    """R_world_base of a unit quaternion, (3, 3) (the paper's appendix)."""
    w, x, y, z = ca.vertsplit(quat)
    return ca.vertcat(
        ca.horzcat(1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        ca.horzcat(2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        ca.horzcat(2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def quat_product(a: Any, b: Any) -> Any:
    """Hamilton product a o b, (4, 1)."""
    aw, av, bw, bv = a[0], a[1:], b[0], b[1:]
    return ca.vertcat(aw * bw - ca.dot(av, bv), aw * bv + bw * av + ca.cross(av, bv))


def quat_exp(rotation_vector: Any) -> Any:
    """Unit quaternion of a rotation vector, (4, 1), as a series: below 0.5 rad exact to 1e-9.

    A polynomial has no division by the angle, which is zero in the initial guess.
    """
    half_squared = ca.dot(rotation_vector, rotation_vector) / 4
    sine = 0.5 * (1 - half_squared / 6 * (1 - half_squared / 20 * (1 - half_squared / 42)))
    cosine = 1 - half_squared / 2 * (1 - half_squared / 12 * (1 - half_squared / 30))
    return ca.vertcat(cosine, sine * rotation_vector)
