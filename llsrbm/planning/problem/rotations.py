"""Rotations and headings of level feet for the planner's expressions; quaternions are w, x, y, z.

A foot that is yawed by phi against the base looks along u = R (cos phi, sin phi, 0); seen from
above that is its heading psi, also when the base is tilted. So for a foot that stands, with
n = (-sin psi, cos psi, 0) across its heading,

    n . u = 0:   phi = atan2(-nb_x, nb_y),   nb = R^T n.
"""

from functools import lru_cache
from typing import Any

import casadi as ca

from llsrbm.models.base import CentroidalModel, no_lift

LEVEL = 1e-12  # square of a gradient below which a surface is level


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


def on_surface(gradient: Any) -> Any:
    """R_world_surface, (3, 3), of a surface that rises by `gradient` (2,) along x and y.

    Its third column is the surface's normal. The fall line is half way between the others, where a
    friction pyramid with these sides has its edge, which holds as much as the cone. The identity
    of a level surface.
    """
    nz = 1 / ca.sqrt(1 + ca.sumsqr(gradient))
    nx, ny = -gradient[0] * nz, -gradient[1] * nz
    across = -nx * ny / (1 + nz)
    leaning = ca.vertcat(
        ca.horzcat(1 - nx**2 / (1 + nz), across, nx),
        ca.horzcat(across, 1 - ny**2 / (1 + nz), ny),
        ca.horzcat(-nx, -ny, nz),
    )
    steep = ca.sumsqr(gradient)
    length = ca.sqrt(2 * ca.fmax(steep, LEVEL))
    along, beside = gradient[0] + gradient[1], gradient[1] - gradient[0]
    c = ca.if_else(steep > LEVEL, along / length, 1)
    s = ca.if_else(steep > LEVEL, beside / length, 0)
    turn = ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1))
    return ca.mtimes(leaning, turn)


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


@lru_cache(maxsize=16)
def feet_seen(model: CentroidalModel) -> ca.Function:
    """x and xdot, (d, L), of feet that are all given in the world.

    Arguments: R_world_base (3, 3); position and velocity of the CoM, (3, 1) m, m/s; angular
    velocity of the base, (3, 1) rad/s, base axes; places and velocities of the feet's lowest
    points, (3, L) m, m/s; their headings and turning rates, (L, 1) rad, rad/s; of models whose arms
    are free their joints' angles and rates, (A n, 1) rad, rad/s. The K instants stand side by side.
    """
    legs = range(model.legs)
    R, r, v, omega = (ca.SX.sym(n, 3, 3 if n == "R" else 1) for n in ("R", "r", "v", "omega"))
    feet, velocity = (ca.SX.sym(n, 3, model.legs) for n in ("feet", "velocity"))
    heading, turning = (ca.SX.sym(n, model.legs) for n in ("heading", "turning"))
    lift = ca.DM([0, 0, model.foot_lift])
    beta = {i: ca.mtimes(R.T, feet[:, i] + lift - r) for i in legs}
    rate = {i: ca.mtimes(R.T, velocity[:, i] - v) - ca.cross(omega, beta[i]) for i in legs}
    if model.coordinates > 3:
        for i in legs:
            nb = across(R, heading[i])
            beta[i] = ca.vertcat(beta[i], relative_yaw(nb))
            rate[i] = ca.vertcat(rate[i], relative_yaw_rate(nb, omega) + turning[i])
    moves: list[Any] = []
    arms = None
    if model.arms is not None:
        angles, rates = (ca.SX.sym(n, model.arms.joints) for n in ("arms", "arm_rates"))
        moves, arms = [angles, rates], model.arms.carried(angles, rates, no_lift)
    offset = model.offset_map(tuple(legs))
    o, o_rate = offset(beta, arms), offset.rate(rate, arms)
    x = [model.foot_in_hip(i, beta[i], o) for i in legs]
    xdot = [model.foot_rate_in_hip(i, rate[i], o_rate) for i in legs]
    return ca.Function(
        "feet_seen",
        [R, r, v, omega, feet, velocity, heading, turning, *moves],
        [ca.densify(ca.horzcat(*x)), ca.densify(ca.horzcat(*xdot))],
    )
