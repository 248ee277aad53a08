"""One motion over time, planned or simulated, under the same names."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from app.replay import Replay
from llsrbm.motion.inertia_ellipsoid import ellipsoid
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.rotation import rotation_matrices
from llsrbm.robots import Robot, load_robot

Array = NDArray[np.float64]

_WHOLE_BODY_EVERY = 3  # frames; an inertia changes slowly, and each costs some 15 microseconds


@dataclass(frozen=True, eq=False)
class Course:
    """A motion at K instants: L legs, J joints in the robot's order; world frame, SI units.

    Attributes:
        robot: that moves.
        time: (K,) s, increasing.
        com, com_velocity: (K, 3) m, m/s.
        base_quat: (K, 4) w, x, y, z; angular_velocity: (K, 3) rad/s of the base.
        linear_momentum, angular_momentum: (K, 3) kg m/s, kg m2/s about the CoM.
        inertia: (K, 3, 3) kg m2 about the CoM: the model's of a plan, the whole body's of a
            simulation.
        foot_force: (K, L, 3) N, sum a foot.
        average_spatial_velocity_norm: (K,) of m/s and rad/s together.
        joint_speed: (K, J) rad/s or m/s.
        torque, torque_limit: (K, J) Nm or N, as in `Plan` and `Rollout`; None of a plan whose
            torques are not known.
    """

    robot: Robot
    time: Array
    com: Array
    com_velocity: Array
    base_quat: Array
    angular_velocity: Array
    linear_momentum: Array
    angular_momentum: Array
    inertia: Array
    foot_force: Array
    average_spatial_velocity_norm: Array
    joint_speed: Array
    torque: Array | None
    torque_limit: Array | None


def planned_course(replay: Replay) -> Course:
    """What was planned, at the instants of the replay's frames."""
    motion = replay.motion
    # At its last instant a plan has no force any more: no interval starts there.
    foot_force = np.concatenate([replay.frames.foot_force[:-1], replay.frames.foot_force[-2:-1]])
    assert motion.joint_velocity is not None  # sampled plans have it
    turning = np.linalg.solve(motion.inertia, motion.angular_momentum[..., None])[..., 0]
    return Course(
        robot=load_robot(replay.plan.jump.robot),
        time=motion.time,
        com=motion.com,
        com_velocity=motion.com_velocity,
        base_quat=motion.base_quat,
        angular_velocity=motion.angular_velocity,
        linear_momentum=motion.linear_momentum,
        angular_momentum=motion.angular_momentum,
        inertia=motion.inertia,
        foot_force=foot_force,
        average_spatial_velocity_norm=np.linalg.norm(
            np.hstack([motion.com_velocity, turning]), axis=1
        ),
        joint_speed=motion.joint_velocity,
        torque=motion.joint_torque,
        torque_limit=motion.joint_torque_limit,
    )


def simulated_course(rollout: Rollout) -> Course:
    """What the whole robot did, at every control tick."""
    robot = load_robot(rollout.jump.robot)
    names = list(rollout.joint_names)
    joints = [names.index(name) for name in robot.joint_names]
    # Momenta are those of the simulated masses.
    trunk = robot.model.inertias[1].mass
    mass = robot.mass + (rollout.disturbance.trunk_mass_factor - 1) * trunk
    # qvel's angular velocity is in the base's axes.
    R = rotation_matrices(rollout.base_quat)
    return Course(
        robot=robot,
        time=rollout.time,
        com=rollout.com,
        com_velocity=rollout.linear_momentum / mass,
        base_quat=rollout.base_quat,
        angular_velocity=np.einsum("kij,kj->ki", R, rollout.qvel[:, 3:6]),
        linear_momentum=rollout.linear_momentum,
        angular_momentum=rollout.angular_momentum,
        inertia=rollout.inertia,
        foot_force=rollout.contact_force,
        average_spatial_velocity_norm=rollout.average_spatial_velocity_norm,
        joint_speed=rollout.qvel[:, 6:][:, joints],
        torque=rollout.torque[:, joints],
        torque_limit=rollout.torque_limit[:, joints],
    )


def principal_moments(robot: Robot, inertia: Array, base_quat: Array) -> Array:
    """Principal moments of inertia, (K, 3) kg m2: those nearest to the base's x, y, z axes.

    Args:
        robot: whose.
        inertia: (K, 3, 3) kg m2 about the CoM.
        base_quat: (K, 4) w, x, y, z.
    """
    axes, _ = ellipsoid(inertia, robot.mass, rotation_matrices(base_quat))
    squares: Array = axes**2
    return robot.mass / 5 * (squares.sum(axis=1, keepdims=True) - squares)


def whole_body_inertia(replay: Replay) -> tuple[Array, Array, Array]:
    """What the robot has in the postures that realise a plan, whatever the model says.

    Returns:
        time (K,) s, inertia about the CoM (K, 3, 3) kg m2, base_quat (K, 4) w, x, y, z.
    """
    robot, motion = load_robot(replay.plan.jump.robot), replay.motion
    kept = np.arange(0, len(motion.time), _WHOLE_BODY_EVERY)
    names = list(motion.joint_names)
    joints = motion.joint_position[kept][:, [names.index(name) for name in robot.joint_names]]
    quat = motion.base_quat[kept]
    q = np.hstack([motion.base_position[kept], quat[:, [1, 2, 3, 0]], joints])
    data, still = robot.model.createData(), np.zeros(robot.model.nv)
    inertia = np.empty((len(kept), 3, 3))
    for k, posture in enumerate(q):
        pin.ccrba(robot.model, data, posture, still)
        inertia[k] = data.Ig.inertia
    return motion.time[kept], inertia, quat
