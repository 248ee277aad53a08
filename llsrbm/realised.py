"""What a plan becomes on the whole robot: inertia and momentum of its postures, by Pinocchio."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from llsrbm.planning.knots import Knots
from llsrbm.postures import joint_speeds, solve_postures
from llsrbm.robots.robot import Robot
from llsrbm.trajectory.plan import Phase

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Realised:
    """The model's word and Pinocchio's at the N intervals' midpoints; z components.

    Attributes:
        time: (N,) s; flight: (N,) whether in flight.
        inertia_model, inertia_true: (N,) kg m2, Izz about the CoM, base axes.
        momentum_plan, momentum_true: (N,) kg m2/s, Lz about the CoM, world axes.
        joint_speed: (N, J) rad/s.
        foot_residual: (N,) m, what inverse kinematics could not reach.
    """

    time: Array
    flight: NDArray[np.bool_]
    inertia_model: Array
    inertia_true: Array
    momentum_plan: Array
    momentum_true: Array
    joint_speed: Array
    foot_residual: Array

    @property
    def inertia_error(self) -> float:
        """RMS of the model's Izz error in flight, share of the true value."""
        relative = self.inertia_model / self.inertia_true - 1
        return float(np.sqrt(np.mean(relative[self.flight] ** 2)))

    @property
    def momentum_error(self) -> tuple[float, float]:
        """RMS and largest error of Lz in flight, shares of the plan's peak."""
        error = (self.momentum_true - self.momentum_plan)[self.flight]
        error = error / np.abs(self.momentum_plan).max()
        return float(np.sqrt(np.mean(error**2))), float(np.abs(error).max())


def realise(knots: Knots, robot: Robot) -> Realised:
    """Postures and velocities at the midpoints: same CoM, attitude, feet, and their velocities."""
    R, position, velocity = knots.mid
    x, xdot = knots.feet_mid
    model = knots.model
    offset, offset_rate = model.offsets(x, xdot)
    beta = offset[:, None] + model.hips + model.mirrors * x
    turning = np.cross(knots.rotation_rate[:, None], beta)
    beta_rate = offset_rate[:, None] + model.mirrors * xdot
    feet = position[:, None] + np.einsum("kij,klj->kli", R, beta)
    foot_velocity = velocity[:, None] + np.einsum("kij,klj->kli", R, beta_rate + turning)
    quat = Rotation.from_matrix(R).as_quat(scalar_first=True)
    omega = np.einsum("kij,kj->ki", R, knots.rotation_rate)
    postures = solve_postures(robot, position, quat, feet)
    speeds = joint_speeds(robot, postures.joint_position, quat, omega, velocity, foot_velocity)

    pin_model, data = robot.model, robot.model.createData()
    inertia, momentum = np.zeros(len(R)), np.zeros(len(R))
    for k in range(len(R)):
        q = np.r_[postures.base_position[k], quat[k, 1:], quat[k, 0], postures.joint_position[k]]
        # The base's linear velocity does not enter the momentum about the CoM.
        v = np.r_[np.zeros(3), knots.rotation_rate[k], speeds[k]]
        pin.ccrba(pin_model, data, q, v)
        inertia[k] = (R[k].T @ data.Ig.inertia @ R[k])[2, 2]
        momentum[k] = data.hg.angular[2]
    return Realised(
        time=(knots.time[:-1] + knots.time[1:]) / 2,
        flight=knots.phase[:-1] == Phase.FLIGHT,
        inertia_model=model.evaluate(x)[1][:, 2, 2],
        inertia_true=inertia,
        momentum_plan=knots.momentum_mid[:, 2],
        momentum_true=momentum,
        joint_speed=speeds,
        foot_residual=postures.residual_m,
    )
