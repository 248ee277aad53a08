"""What a plan becomes on the whole robot: inertia and momentum of its postures, by Pinocchio."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from llsrbm.body.postures import joint_speeds, solve_postures
from llsrbm.planning.problem.headings import heading_rates, headings
from llsrbm.planning.problem.knots import Knots
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Realised:
    """The model's word and Pinocchio's at the N intervals' midpoints.

    Attributes:
        time: (N,) s; flight: (N,) whether in flight.
        inertias_model, inertias_true: (N, 3) kg m2, Ixx, Iyy, Izz about the CoM, base axes.
        momenta_plan, momenta_true: (N, 3) kg m2/s, angular, about the CoM, world axes.
        rate_error: (N, 3) rad/s, base axes: how much faster than planned the base turns if the
            whole robot has the planned momentum and its joints move as planned.
        interval: (N,) s.
        joint_speed: (N, J) rad/s or m/s.
        foot_residual: (N,) m, what inverse kinematics could not reach.
    """

    time: Array
    flight: NDArray[np.bool_]
    inertias_model: Array
    inertias_true: Array
    momenta_plan: Array
    momenta_true: Array
    rate_error: Array
    interval: Array
    joint_speed: Array
    foot_residual: Array

    @property
    def inertia_model(self) -> Array:
        """(N,) kg m2, Izz."""
        return self.inertias_model[:, 2]

    @property
    def inertia_true(self) -> Array:
        """(N,) kg m2, Izz."""
        return self.inertias_true[:, 2]

    @property
    def momentum_plan(self) -> Array:
        """(N,) kg m2/s, Lz."""
        return self.momenta_plan[:, 2]

    @property
    def momentum_true(self) -> Array:
        """(N,) kg m2/s, Lz."""
        return self.momenta_true[:, 2]

    @property
    def inertia_errors(self) -> Array:
        """(3,) RMS of the model's errors of Ixx, Iyy, Izz in flight, shares of the true values."""
        relative = (self.inertias_model / self.inertias_true - 1)[self.flight]
        errors: Array = np.sqrt(np.mean(relative**2, axis=0))
        return errors

    @property
    def momentum_errors(self) -> Array:
        """(3,) RMS errors of Lx, Ly, Lz in flight, shares of the peak of |L| over the plan."""
        error = (self.momenta_true - self.momenta_plan)[self.flight]
        peak = np.linalg.norm(self.momenta_plan, axis=1).max()
        errors: Array = np.sqrt(np.mean(error**2, axis=0)) / peak
        return errors

    @property
    def inertia_error(self) -> float:
        """RMS of the model's Izz error in flight, share of the true value."""
        return float(self.inertia_errors[2])

    @property
    def momentum_error(self) -> tuple[float, float]:
        """RMS and largest error of Lz in flight, shares of the plan's peak."""
        error = (self.momentum_true - self.momentum_plan)[self.flight]
        error = error / np.abs(self.momentum_plan).max()
        return float(np.sqrt(np.mean(error**2))), float(np.abs(error).max())

    @property
    def turn_error(self) -> Array:
        """(3,) rad, base axes: what `rate_error` comes to over flight."""
        turn: Array = self.interval[self.flight] @ self.rate_error[self.flight]
        return turn


def realise(knots: Knots, robot: Robot) -> Realised:
    """Postures and velocities at the midpoints: same CoM, attitude, feet, and their velocities."""
    R, position, velocity = knots.mid
    x, xdot = knots.feet_mid
    model, omega_base = knots.model, knots.rotation_rate
    offset, offset_rate = model.offsets(x, xdot)
    beta = offset[:, None] + model.hips + model.mirrors * x[..., :3]
    turning = np.cross(omega_base[:, None], beta)
    beta_rate = offset_rate[:, None] + model.mirrors * xdot[..., :3]
    feet = position[:, None] + np.einsum("kij,klj->kli", R, beta)
    foot_velocity = velocity[:, None] + np.einsum("kij,klj->kli", R, beta_rate + turning)
    quat = Rotation.from_matrix(R).as_quat(scalar_first=True)
    omega = np.einsum("kij,kj->ki", R, omega_base)
    foot_quat, foot_omega = None, None
    if model.coordinates > 3:
        yaw, yaw_rate = model.turn_mirrors * x[..., 3], model.turn_mirrors * xdot[..., 3]
        foot_quat = _about_vertical(headings(R, yaw))
        foot_omega = heading_rates(R, yaw, yaw_rate, omega_base)[..., None] * [0.0, 0.0, 1.0]
    postures = solve_postures(robot, position, quat, feet, foot_quat)
    speeds = joint_speeds(
        robot, postures.joint_position, quat, omega, velocity, foot_velocity, foot_omega
    )

    pin_model, data = robot.model, robot.model.createData()
    inertias, momenta, rate_error = np.zeros((3, len(R), 3))
    for k in range(len(R)):
        q = np.r_[postures.base_position[k], quat[k, 1:], quat[k, 0], postures.joint_position[k]]
        # The base's linear velocity does not enter the momentum about the CoM.
        v = np.r_[np.zeros(3), omega_base[k], speeds[k]]
        pin.ccrba(pin_model, data, q, v)
        inertias[k] = np.diag(R[k].T @ data.Ig.inertia @ R[k])
        momenta[k] = data.hg.angular
        missing = knots.momentum_mid[k] - data.hg.angular
        rate_error[k] = R[k].T @ np.linalg.solve(data.Ig.inertia, missing)
    return Realised(
        time=(knots.time[:-1] + knots.time[1:]) / 2,
        flight=np.asarray(~knots.layout.standing[:-1].any(axis=1)),
        inertias_model=np.diagonal(model.evaluate(x)[1], axis1=1, axis2=2),
        inertias_true=inertias,
        momenta_plan=knots.momentum_mid,
        momenta_true=momenta,
        rate_error=rate_error,
        interval=knots.dt,
        joint_speed=speeds,
        foot_residual=postures.residual_m,
    )


def _about_vertical(angle: Array) -> Array:
    """Quaternions w, x, y, z (..., 4) of turns (...) rad about z."""
    zero = np.zeros_like(angle)
    return np.stack([np.cos(angle / 2), zero, zero, np.sin(angle / 2)], axis=-1)
