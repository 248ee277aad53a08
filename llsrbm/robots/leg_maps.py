"""Maps from where a foot is to where its leg's mass is, fitted to the URDF's own legs.

A leg's links follow the foot through inverse kinematics; a planner wants that as a few polynomials.
All legs are mirrored onto the reference leg (x = M (foot - hip), base axes) and fitted together.
For lines and soles x has a fourth coordinate, the yaw relative to the base, det(M) times it, and
the foot is level; d = 3 or 4 counts the coordinates.

    c(x)     leg's CoM in the mirrored hip frame, affine and quadratic, value and derivative
    I_c(x)   leg's inertia about its CoM
    S(x)     S(x) dx/dt is the angular momentum of the leg's links about the leg's CoM

I_c and S are affine, of sliding legs quadratic. With them the leg's part of the centroidal inertia
and angular momentum, base at rest, is m_l P(a) + M I_c M and
m_l a x M (dc/dx) dx/dt + det(M) M S dx/dt, a = hip + M c - CoM.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import casadi as ca
import numpy as np

from llsrbm.arrays import Array


@dataclass(frozen=True, eq=False)
class LegFit:
    """Mass properties and leg maps of a robot with L legs; SI units.

    Attributes:
        total_mass, leg_mass, trunk_mass: kg: all, mean over the legs, what is not leg.
        trunk_com: (3,) m, base frame; trunk_inertia: (3, 3) kg m2 about it, base axes.
        hips: (L, 3) m, base frame; mirrors: (L, 3) of +1 or -1, the diagonals of M.
        com_affine: (1 + d, 3): [1, x] -> c, m.
        com_quadratic: (10 or 15, 3): [1, x, squares, products] -> c, m.
        inertia_map: (f, 9): features -> I_c row by row, kg m2, symmetric; the features are affine,
            f = 1 + d, or quadratic.
        spin_map: (f, 3 d): features -> S row by row, kg m, a yaw's column kg m2.
        proportional_mass, proportional_fraction: kg: the paper's point mass, the links from the hip
            joint outwards; and where its rule puts it, as a fraction of foot -> hip.
        residuals: RMS error of each map over the samples, by the map's name, in its unit; names
            ending in "_slope" are the error of a map's derivative.
    """

    total_mass: float
    leg_mass: float
    trunk_mass: float
    trunk_com: Array
    trunk_inertia: Array
    hips: Array
    mirrors: Array
    com_affine: Array
    com_quadratic: Array
    inertia_map: Array
    spin_map: Array
    proportional_mass: float
    proportional_fraction: float
    residuals: dict[str, float]


def affine_features(x: Array) -> Array:
    """(..., d) -> (..., 1 + d): 1, x, y, z and so on."""
    return np.concatenate([np.ones((*x.shape[:-1], 1)), x], axis=-1)


def quadratic_features(x: Array) -> Array:
    """(..., d) -> (..., 10 or 15): 1, x, y, z, xx, yy, zz, xy, xz, yz; likewise of four."""
    i, j = _pairs(x.shape[-1])
    return np.concatenate([affine_features(x), x * x, x[..., i] * x[..., j]], -1)


def quadratic_terms(x: Any) -> Any:
    """`quadratic_features` of a CasADi matrix (d, 1), as a column."""
    each = ca.vertsplit(x)
    products = [a * b for a, b in combinations(each, 2)]
    return ca.vertcat(1, *each, *(a * a for a in each), *products)


def quadratic_term_rates(x: Any, x_rate: Any) -> Any:
    """Time derivative of `quadratic_terms`."""
    x, v = ca.vertsplit(x), ca.vertsplit(x_rate)
    squares = [2 * a * u for a, u in zip(x, v, strict=True)]
    products = [x[i] * v[j] + x[j] * v[i] for i, j in combinations(range(len(x)), 2)]
    return ca.vertcat(0, *v, *squares, *products)


def affine_slopes(x: Array) -> Array:
    """(..., d) -> (..., 1 + d, d): derivative of the affine features."""
    d = x.shape[-1]
    slopes = np.zeros((*x.shape[:-1], 1 + d, d))
    slopes[..., 1:, :] = np.eye(d)
    return slopes


def quadratic_slopes(x: Array) -> Array:
    """(..., d) -> (..., 10 or 15, d): derivative of the quadratic features."""
    d = x.shape[-1]
    squares, products = [(i, i) for i in range(d)], zip(*_pairs(d), strict=True)
    pairs = [*squares, *products]
    slopes = np.zeros((*x.shape[:-1], 1 + d + len(pairs), d))
    slopes[..., 1 : 1 + d, :] = np.eye(d)
    for row, (i, j) in enumerate(pairs, start=1 + d):
        slopes[..., row, i] += x[..., j]
        slopes[..., row, j] += x[..., i]
    return slopes


def _pairs(d: int) -> tuple[list[int], list[int]]:
    first, second = zip(*combinations(range(d), 2), strict=True)
    return list(first), list(second)
