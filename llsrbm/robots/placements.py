"""Where a robot's bodies are in many postures at once."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


def placements(model: pin.Model, q: Array) -> tuple[Array, Array]:
    """Turns (T, joints, 3, 3) and origins (T, joints, 3) m of all joints, in the world.

    As `pin.forwardKinematics` in postures q (T, nq), of a free base and joints that turn about or
    slide along one axis. The first joint is the world.
    """
    turn = np.empty((len(q), model.njoints, 3, 3))
    origin = np.empty((len(q), model.njoints, 3))
    turn[:, 0], origin[:, 0] = np.eye(3), 0.0
    turn[:, 1] = Rotation.from_quat(q[:, 3:7]).as_matrix()
    origin[:, 1] = q[:, :3]
    for j in range(2, model.njoints):
        joint, placed, parent = model.joints[j], model.jointPlacements[j], model.parents[j]
        value = q[:, joint.idx_q]
        own, along = _motion(joint, value)
        at = turn[:, parent] @ placed.rotation
        origin[:, j] = origin[:, parent] + turn[:, parent] @ placed.translation
        origin[:, j] += np.einsum("tij,tj->ti", at, along)
        turn[:, j] = at @ own
    return turn, origin


def _motion(joint: pin.JointModel, value: Array) -> tuple[Array, Array]:
    """Turns (T, 3, 3) and shifts (T, 3) m of a joint at its positions (T,)."""
    data = joint.createData()
    joint.calc(data, np.zeros(joint.idx_q + 1), np.zeros(joint.idx_v + 1))
    subspace = np.asarray(data.S.matrix if hasattr(data.S, "matrix") else data.S).ravel()
    shift, axis = subspace[:3], subspace[3:]
    return Rotation.from_rotvec(value[:, None] * axis).as_matrix(), value[:, None] * shift
