"""Momentum and inertia of the whole body, by Pinocchio."""

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.robots.robot import Robot


def momentum_and_inertia(
    robot: Robot, joint_position: Array, joint_velocity: Array, rate: Array
) -> tuple[Array, Array]:
    """Angular momentum (K, 3) kg m2/s and inertia (K, 3, 3) kg m2 about the CoM, base axes.

    Args:
        robot: the robot.
        joint_position, joint_velocity: (K, J) rad or m, and per s.
        rate: (K, 3) rad/s, angular velocity of the base, base axes.
    """
    still = np.zeros_like(rate)  # the base's place and attitude do not matter
    upright = np.tile(pin.neutral(robot.model)[:7], (len(rate), 1))
    q, v = np.hstack([upright, joint_position]), np.hstack([still, rate, joint_velocity])
    _, inertia, momentum = centroidal_states(robot.model, q, v)
    return momentum[:, 3:], inertia


def momentum_maps(robot: Robot, joint_position: Array) -> Array:
    """(K, 3, 3 + J): angular momentum about the CoM of the base's rate and the joints' speeds.

    kg m2 (kg m where a joint slides), base axes, at joint positions (K, J) rad or m.
    """
    model, data = robot.model, robot.model.createData()
    maps = np.empty((len(joint_position), 3, model.nv - 3))
    q = pin.neutral(model)
    for k, joints in enumerate(joint_position):
        q[7:] = joints
        maps[k] = pin.computeCentroidalMap(model, data, q)[3:, 3:]
    return maps


def centroidal_states(model: pin.Model, q: Array, v: Array) -> tuple[Array, Array, Array]:
    """CoM (K, 3) m, inertia about it (K, 3, 3) kg m2 and momentum (K, 6), linear first.

    World frame, of states (K, nq), (K, nv) in Pinocchio's convention.
    """
    data = model.createData()
    com, inertia, momentum = np.empty((len(q), 3)), np.empty((len(q), 3, 3)), np.empty((len(q), 6))
    for k in range(len(q)):
        pin.ccrba(model, data, q[k], v[k])
        com[k], inertia[k], momentum[k] = data.com[0], data.Ig.inertia, data.hg.vector
    return com, inertia, momentum


def base_velocities(
    robot: Robot,
    com_velocity: Array,
    base_position: Array,
    base_quat: Array,
    omega: Array,
    joint_position: Array,
    joint_velocity: Array,
) -> Array:
    """(K, 3) m/s, world axes: of a base's origin with which the whole body's CoM moves so.

    `omega`: (K, 3) rad/s, base axes.
    """
    still = np.zeros_like(omega)
    q = np.hstack([base_position, base_quat[:, [1, 2, 3, 0]], joint_position])
    momentum = centroidal_states(robot.model, q, np.hstack([still, omega, joint_velocity]))[2]
    return com_velocity - momentum[:, :3] / robot.mass
