"""Inverse dynamics of the whole body under contact forces, by Pinocchio."""

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.mechanics import cross
from llsrbm.robots.drives.torques import friction_torque
from llsrbm.robots.feet import pushed_points
from llsrbm.robots.placements import placements, pushes
from llsrbm.robots.robot import Robot


def inverse_dynamics(model: pin.Model, q: Array, v: Array, a: Array) -> Array:
    """M a + h, rotors in M, (K, nv) N, Nm, of states and accelerations as Pinocchio has them."""
    data = model.createData()
    found = np.empty((len(q), model.nv))
    for k in range(len(q)):
        found[k] = pin.rnea(model, data, q[k], v[k], a[k])
    return found


def efforts(
    robot: Robot, q: Array, v: Array, a: Array, force: Array, normals: Array | None = None
) -> Array:
    """Force and moment on the base's origin (base axes) and drives' torques, (K, 6 + J) N, Nm.

    The first six are zero where the motion is possible.

    Args:
        robot: that moves.
        q, v, a: (K, nq), (K, nv), (K, nv) of the whole robot, Pinocchio's convention.
        force: (K, C, 3) N at the contact points of the feet, world axes.
        normals: (K, L, 3) unit, of what each foot stands on; None: it is level.
    """
    placed = placements(robot.model, q)
    points = pushed_points(robot, placed, normals)
    found = inverse_dynamics(robot.model, q, v, a)
    found[:, 6:] += friction_torque(robot, v[:, 6:])
    return found - of_contacts(robot, placed, points, force.reshape(points.shape))


def of_contacts(robot: Robot, placed: tuple[Array, Array], points: Array, forces: Array) -> Array:
    """(K, nv) N, Nm: J^T f of forces (K, L, c, 3) N at points of the feet (K, L, c, 3) m, world.

    `placed`: of `placements`.
    """
    total, moment = forces.sum(axis=2), cross(points, forces).sum(axis=2)
    parents = [robot.model.frames[leg.foot_frame_id].parentJoint for leg in robot.legs]
    each = [
        pushes(robot.model, placed, joint, total[:, leg], moment[:, leg])
        for leg, joint in enumerate(parents)
    ]
    return np.sum(each, axis=0, dtype=np.float64)
