"""Where a robot's bodies are in many postures at once, how they move, and what pushes do to them.

All for a free base and joints that turn about or slide along one axis; the first joint is the
world. K postures q (K, nq), velocities v (K, nv) in Pinocchio's convention.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from llsrbm.arrays import Array
from llsrbm.mechanics import apply, cross

_BASE = slice(0, 3), slice(3, 6)  # velocities of the free base: linear, angular


def placements(model: pin.Model, q: Array) -> tuple[Array, Array]:
    """Turns (K, joints, 3, 3) and origins (K, joints, 3) m of all joints, in the world.

    As `pin.forwardKinematics`.
    """
    turn = np.empty((len(q), model.njoints, 3, 3))
    origin = np.empty((len(q), model.njoints, 3))
    turn[:, 0], origin[:, 0] = np.eye(3), 0.0
    turn[:, 1] = Rotation.from_quat(q[:, 3:7]).as_matrix()
    origin[:, 1] = q[:, :3]
    for j in range(2, model.njoints):
        joint, placed, parent = model.joints[j], model.jointPlacements[j], model.parents[j]
        value = q[:, joint.idx_q][:, None]
        shift, axis = subspace(joint)
        own, along = Rotation.from_rotvec(value * axis).as_matrix(), value * shift
        at = turn[:, parent] @ placed.rotation
        origin[:, j] = origin[:, parent] + turn[:, parent] @ placed.translation
        origin[:, j] += np.einsum("tij,tj->ti", at, along)
        turn[:, j] = at @ own
    return turn, origin


def velocities(model: pin.Model, placed: tuple[Array, Array], v: Array) -> tuple[Array, Array]:
    """Linear velocities of the joints' origins (K, joints, 3) m/s, and angular ones, rad/s; world.

    `placed`: of `placements`.
    """
    turn, origin = placed
    linear, angular = np.zeros_like(origin), np.zeros_like(origin)
    linear[:, 1], angular[:, 1] = (apply(turn[:, 1], v[:, part]) for part in _BASE)
    for j in range(2, model.njoints):
        joint, parent = model.joints[j], model.parents[j]
        rate = v[:, joint.idx_v][:, None]
        shift, axis = subspace(joint)
        carried = cross(angular[:, parent], origin[:, j] - origin[:, parent])
        linear[:, j] = linear[:, parent] + carried + rate * (turn[:, j] @ shift)
        angular[:, j] = angular[:, parent] + rate * (turn[:, j] @ axis)
    return linear, angular


def pushes(
    model: pin.Model, placed: tuple[Array, Array], joint: int, force: Array, moment: Array
) -> Array:
    """J^T f, (K, nv) N, Nm, of a force (K, 3) N on a joint's body, the base in its own axes.

    `moment`: (K, 3) Nm, its own about the world's origin.
    """
    turn, origin = placed
    found = np.zeros((len(force), model.nv))
    to_base = np.swapaxes(turn[:, 1], -1, -2)
    about_base = moment - cross(origin[:, 1], force)
    for part, pushed in zip(_BASE, (force, about_base), strict=True):
        found[:, part] = apply(to_base, pushed)
    for j in list(model.supports[joint])[2:]:
        shift, axis = subspace(model.joints[j])
        about = moment - cross(origin[:, j], force)
        along = (turn[:, j] @ shift) * force + (turn[:, j] @ axis) * about
        found[:, model.joints[j].idx_v] = along.sum(axis=1)
    return found


def subspace(joint: pin.JointModel) -> tuple[Array, Array]:
    """Directions (3,) in which a joint shifts and turns its body, in its own axes."""
    data = joint.createData()
    joint.calc(data, np.zeros(joint.idx_q + 1), np.zeros(joint.idx_v + 1))
    subspace = np.asarray(data.S.matrix if hasattr(data.S, "matrix") else data.S).ravel()
    return subspace[:3], subspace[3:]
