"""One motion over time, planned, simulated or from a file, under the same names."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.analysis.inertia_ellipsoid import ellipsoid
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.rotation import rotation_matrices
from llsrbm.motion.whole_body import WholeBodyMotion, motion_at_ticks
from llsrbm.robots import Robot

Array = NDArray[np.float64]

_WHOLE_BODY_EVERY = 3  # frames; an inertia changes slowly, and each costs some 15 microseconds


@dataclass(frozen=True, eq=False)
class Signals:
    """A motion at K instants: L legs, J joints in the robot's order; world frame, SI units.

    Attributes:
        robot: that moves.
        time: (K,) s, increasing.
        com, com_velocity: (K, 3) m, m/s.
        base_quat: (K, 4) w, x, y, z; angular_velocity: (K, 3) rad/s of the base.
        linear_momentum, angular_momentum: (K, 3) kg m/s, kg m2/s about the CoM.
        inertia: (K, 3, 3) kg m2 about the CoM: the model's of a plan, the whole body's of a
            simulation.
        foot_force: (K, L, 3) N, sum a foot; None of a motion of which no file tells it.
        average_spatial_velocity_norm: (K,) of m/s and rad/s together.
        joint_speed: (K, J) rad/s or m/s.
        torque, torque_limit: (K, J) Nm or N, as in `Plan` and `Rollout`; None where they are not
            known.
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
    foot_force: Array | None
    average_spatial_velocity_norm: Array
    joint_speed: Array
    torque: Array | None
    torque_limit: Array | None


def signals_of(motion: WholeBodyMotion, mass: float | None = None) -> Signals:
    """A motion's quantities at its own instants.

    Args:
        motion: of a plan, of a simulation or from a file.
        mass: kg, that has its momenta; None: the robot's.
    """
    velocity = motion.linear_momentum / (motion.robot.mass if mass is None else mass)
    turning = np.linalg.solve(motion.inertia, motion.angular_momentum[..., None])[..., 0]
    return Signals(
        robot=motion.robot,
        time=motion.time,
        com=motion.com,
        com_velocity=velocity,
        base_quat=motion.base_quat,
        angular_velocity=motion.angular_velocity,
        linear_momentum=motion.linear_momentum,
        angular_momentum=motion.angular_momentum,
        inertia=motion.inertia,
        foot_force=motion.foot_force,
        average_spatial_velocity_norm=np.linalg.norm(np.hstack([velocity, turning]), axis=1),
        joint_speed=motion.joint_velocity,
        torque=motion.joint_torque,
        torque_limit=motion.joint_torque_limit,
    )


def simulated_signals(rollout: Rollout) -> Signals:
    """What the whole robot did, at every control tick."""
    motion = motion_at_ticks(rollout, np.arange(len(rollout.time)))
    # Momenta are those of the simulated masses.
    trunk = motion.robot.model.inertias[1].mass
    mass = motion.robot.mass + (rollout.disturbance.trunk_mass_factor - 1) * trunk
    norm = rollout.average_spatial_velocity_norm
    return replace(signals_of(motion, mass), average_spatial_velocity_norm=norm)


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


def whole_body_inertia(motion: WholeBodyMotion) -> tuple[Array, Array, Array]:
    """What the robot has in its postures, whatever a planner's model says.

    Returns:
        time (K,) s, inertia about the CoM (K, 3, 3) kg m2, base_quat (K, 4) w, x, y, z.
    """
    robot = motion.robot
    kept = np.arange(0, len(motion.time), _WHOLE_BODY_EVERY)
    quat = motion.base_quat[kept]
    q = np.hstack([motion.base_position[kept], quat[:, [1, 2, 3, 0]], motion.joint_position[kept]])
    data, still = robot.model.createData(), np.zeros(robot.model.nv)
    inertia = np.empty((len(kept), 3, 3))
    for k, posture in enumerate(q):
        pin.ccrba(robot.model, data, posture, still)
        inertia[k] = data.Ig.inertia
    return motion.time[kept], inertia, quat
