"""Where level feet look: between their heading in the world and their yaw relative to the base.

A foot that is yawed by phi against the base looks along u = R (cos phi, sin phi, 0); seen from
above that is its heading psi, also when the base is tilted. So for a foot that stands, with
n = (-sin psi, cos psi, 0) across its heading,

    n . u = 0:   phi = atan2(-nb_x, nb_y),   nb = R^T n.

CasADi expressions first; the same for K instants in NumPy below, by other formulas where there are.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def across(R_world_base: Any, heading: Any) -> Any:
    """nb = R^T n, (3, 1): the horizontal direction across a heading, rad, in base axes."""
    return ca.mtimes(R_world_base.T, ca.vertcat(-ca.sin(heading), ca.cos(heading), 0))


def relative_yaw(across_base: Any) -> Any:
    """phi of a foot that stands, rad, from `across`."""
    return ca.atan2(-across_base[0], across_base[1])


def relative_yaw_rate(across_base: Any, angular_velocity: Any) -> Any:
    """Time derivative of phi of a foot that stands, rad/s; angular velocity in base axes."""
    nb, rate = across_base, -ca.cross(angular_velocity, across_base)
    return (nb[0] * rate[1] - nb[1] * rate[0]) / (nb[0] ** 2 + nb[1] ** 2)


def direction(R_world_base: Any, yaw: Any) -> Any:
    """(cos psi, sin psi), (2, 1), of a foot yawed by `yaw`, rad, against the base."""
    u = ca.mtimes(R_world_base[:2, :2], ca.vertcat(ca.cos(yaw), ca.sin(yaw)))
    return u / ca.norm_2(u)


def heading_rate(up_base: Any, yaw: Any, yaw_rate: Any, angular_velocity: Any) -> Any:
    """Time derivative of psi, rad/s, of a foot whose yaw against the base changes.

    With v = (cos phi, sin phi, 0), v' = omega x v + phi' e_z x v and up = R^T e_z it is
    up . (v x v') / |v, seen from above|^2. Angular velocity and `up_base` in base axes.
    """
    v = ca.vertcat(ca.cos(yaw), ca.sin(yaw), 0)
    up, w = up_base, angular_velocity
    rise = ca.dot(up, v)
    turning = ca.dot(up, w) - rise * ca.dot(w, v) + up[2] * yaw_rate
    return turning / (1 - rise**2)


# ---- NumPy, K instants and L feet


def relative_yaws(R_world_base: Array, heading: Array) -> Array:
    """(K, L) rad, of headings (K, L) rad and R (K, 3, 3)."""
    n = np.stack([-np.sin(heading), np.cos(heading), np.zeros_like(heading)], axis=-1)
    nb = n @ R_world_base
    return np.arctan2(-nb[..., 0], nb[..., 1])


def relative_yaw_rates(R_world_base: Array, heading: Array, angular_velocity: Array) -> Array:
    """(K, L) rad/s of feet that stand; angular velocity (K, 3) rad/s, base axes.

    psi' = 0 solved for phi'.
    """
    yaw = relative_yaws(R_world_base, heading)
    still = heading_rates(R_world_base, yaw, np.zeros_like(yaw), angular_velocity)
    turning = heading_rates(R_world_base, yaw, np.ones_like(yaw), angular_velocity)
    return -still / (turning - still)


def headings(R_world_base: Array, yaw: Array) -> Array:
    """(K, L) rad, of yaws (K, L) rad; continuous in time, which is axis 0."""
    u = _ahead(R_world_base, yaw)
    return np.unwrap(np.arctan2(u[..., 1], u[..., 0]), axis=0)


def heading_rates(
    R_world_base: Array, yaw: Array, yaw_rate: Array, angular_velocity: Array
) -> Array:
    """(K, L) rad/s, of yaws (K, L) and their rates; angular velocity (K, 3), base axes."""
    v = np.stack([np.cos(yaw), np.sin(yaw), np.zeros_like(yaw)], axis=-1)
    sideways = np.stack([-np.sin(yaw), np.cos(yaw), np.zeros_like(yaw)], axis=-1)
    v_rate = np.cross(angular_velocity[:, None], v) + yaw_rate[..., None] * sideways
    back = np.swapaxes(R_world_base, -1, -2)
    u, u_rate = v @ back, v_rate @ back
    turning = u[..., 0] * u_rate[..., 1] - u[..., 1] * u_rate[..., 0]
    rates: Array = turning / (u[..., 0] ** 2 + u[..., 1] ** 2)
    return rates


def _ahead(R_world_base: Array, yaw: Array) -> Array:
    v = np.stack([np.cos(yaw), np.sin(yaw), np.zeros_like(yaw)], axis=-1)
    return v @ np.swapaxes(R_world_base, -1, -2)
