"""Inertia and momentum of a plan's postures on the whole robot, by Pinocchio."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llsrbm.mechanics import rotation_matrices, slerp
from llsrbm.planning.problem.constraints.truth import whole_body
from llsrbm.planning.problem.knots import Knots

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Realised:
    """Numbers of the model and of Pinocchio in the middles of N intervals.

    Attributes:
        time: (N,) s; flight: (N,) whether in flight.
        inertias_model, inertias_true: (N, 3) kg m2, Ixx, Iyy, Izz about the CoM, base axes.
        momenta_plan, momenta_true: (N, 3) kg m2/s, angular, about the CoM, world axes.
        rate_error: (N, 3) rad/s, base axes: how much faster than planned the base turns if the
            whole robot has the planned momentum and its joints move as planned.
        interval: (N,) s.
        joint_speed: (N, J) rad/s or m/s.
        foot_residual: (N,) m, left over by inverse kinematics.
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
    def turn_error(self) -> Array:
        """(3,) rad, base axes: what `rate_error` comes to over flight."""
        turn: Array = self.interval[self.flight] @ self.rate_error[self.flight]
        return turn


def realise(knots: Knots) -> Realised:
    """Postures and velocities in the middles of the intervals, and the model's numbers there."""
    loads = knots.loads
    middle = rotation_matrices(slerp(knots.quat[:-1], knots.quat[1:], np.array(0.5)))
    momenta, inertias = whole_body(knots)
    rate_error = np.linalg.solve(inertias, (knots.momentum_mean - momenta)[..., None])[..., 0]
    model = (knots.inertia[:-1] + knots.inertia[1:]) / 2
    return Realised(
        time=loads.time,
        flight=np.asarray(~knots.layout.standing[:-1].any(axis=1)),
        inertias_model=np.diagonal(model, axis1=1, axis2=2),
        inertias_true=np.diagonal(inertias, axis1=1, axis2=2),
        momenta_plan=np.einsum("kij,kj->ki", middle, knots.momentum_mean),
        momenta_true=np.einsum("kij,kj->ki", middle, momenta),
        rate_error=rate_error,
        interval=knots.dt,
        joint_speed=loads.joint_velocity,
        foot_residual=loads.foot_residual,
    )
