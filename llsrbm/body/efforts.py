"""Inverse dynamics of the whole body under contact forces, by Pinocchio."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.robots.drives.torques import friction_torque
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]


def inverse_dynamics(model: pin.Model, q: Array, v: Array, a: Array) -> Array:
    """M a + h, rotors in M, (K, nv) N, Nm, of states and accelerations as Pinocchio has them."""
    data = model.createData()
    found = np.empty((len(q), model.nv))
    for k in range(len(q)):
        found[k] = pin.rnea(model, data, q[k], v[k], a[k])
    return found


def efforts(robot: Robot, q: Array, v: Array, a: Array, force: Array) -> Array:
    """Force and moment on the base's origin (base axes) and drives' torques, (K, 6 + J) N, Nm.

    The first six are zero where the motion is possible.

    Args:
        robot: that moves.
        q, v, a: (K, nq), (K, nv), (K, nv) of the whole robot, Pinocchio's convention.
        force: (K, C, 3) N at the contact points of the feet, world axes.
    """
    model, data = robot.model, robot.model.createData()
    found = inverse_dynamics(model, q, v, a)
    found[:, 6:] += friction_torque(robot, v[:, 6:])
    pushes = force.reshape(len(q), len(robot.legs), -1, 3)
    for k in range(len(q)):
        pin.computeJointJacobians(model, data, q[k])
        pin.updateFramePlacements(model, data)
        for leg, push in zip(robot.legs, pushes[k], strict=True):
            frame, axes = leg.foot_frame_id, pin.LOCAL_WORLD_ALIGNED
            jacobian = pin.getFrameJacobian(model, data, frame, axes)
            arms = robot.corners @ data.oMf[frame].rotation.T - [0.0, 0.0, robot.foot_lift]
            found[k] -= jacobian.T @ np.append(push.sum(axis=0), np.cross(arms, push).sum(axis=0))
    return found
