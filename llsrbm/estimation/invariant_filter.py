"""`InvariantFilter`: attitude, velocity and position by an inertial unit and feet that stand.

The contact-aided invariant extended Kalman filter of Hartley, Ghaffari, Eustice and Grizzle (2020).
The state is X = (R, v, p, d_1 .. d_L), attitude, velocity and position of the base and the feet's
middles in the world, and the unit's biases b_g, b_a. Its error is right-invariant,

    X_estimated = exp(xi) X,    e.g.  R_estimated = exp(xi_R) R,
    v_estimated = exp(xi_R) v + xi_v  to first order, and p, d alike.

So in its dynamics only the biases meet the estimate, and not at all in the measurement of a foot
that legs of joint angles a put at s(a) in the base,

    R s(a) + p - d = 0,   estimated:  xi_p - xi_d + noise:

a wrong attitude does not make it believe in wrong directions. Directions that feet cannot tell, yaw
and place, stay unknown. With a tilt that is wrong by 5 deg at first, 0.44 deg are left of it at
lift-off of a Go2 half a second later, 0.56 deg with the usual additive error; from where the
inertial unit begins both do the same.

A ball of radius r that rolls moves its middle: d' = w_foot x r e_z.
"""

import numpy as np
import pinocchio as pin
from scipy.linalg.lapack import dposv

from llsrbm.arrays import Array, BoolArray
from llsrbm.mechanics import GRAVITY, skew

# Places in the error, of attitude, velocity, position, biases; feet follow.
TURN, SPEED, PLACE, GYRO_BIAS, ACCELERATION_BIAS, _FEET = (
    slice(3 * k, 3 * k + 3) for k in range(6)
)
FIRST_FOOT = _FEET.start
_GRAVITY = np.array([0.0, 0.0, -GRAVITY])
_SKEW_GRAVITY = skew(_GRAVITY)
_EACH = np.arange(3)
_AXES_OF_PLACE = PLACE.start + _EACH
# v @ _SKEWS, as a 3 x 3 matrix, times w is v x w.
_SKEWS = skew(np.eye(3)).reshape(3, 9)


def _skew(vectors: Array) -> Array:
    """(3 K, 3): skew matrices of (K, 3), one below the other."""
    return (vectors @ _SKEWS).reshape(-1, 3)


class InvariantFilter:
    """The filter's estimate and covariance; L feet, n = 15 + 3 L errors.

    Attributes:
        R_world_base: (3, 3); velocity, position: (3,) m/s, m of the base's origin, world frame.
        gyro_bias, acceleration_bias: (3,) rad/s, m/s2, base frame.
        feet: (L, 3) m, world frame: middles of those that stand.
        covariance: (n, n) of the error: `TURN`, `SPEED`, `PLACE`, `GYRO_BIAS`, `ACCELERATION_BIAS`
            and the feet, three of each.
    """

    def __init__(self, legs: int) -> None:
        n = FIRST_FOOT + 3 * legs
        self.R_world_base = np.eye(3)
        self.velocity, self.position, self.gyro_bias, self.acceleration_bias = np.zeros((4, 3))
        self.feet = np.zeros((legs, 3))
        self.covariance = np.zeros((n, n))
        self._transition = np.eye(n)
        self._turned = np.zeros((n, 3))

    def propagate(
        self,
        dt: float,
        gyro: Array,
        acceleration: Array,
        foot_velocity: Array,
        noise: Array,
    ) -> None:
        """Let `dt`, s, pass with the unit's means over it, (3,) rad/s and m/s2.

        `foot_velocity`: (L, 3) m/s of the feet's middles, world frame; `noise`: (n,) variances that
        grow in a second: of attitude (by the gyroscope), velocity, position, biases and feet.
        """
        rate, force = gyro - self.gyro_bias, acceleration - self.acceleration_bias
        self._propagate_covariance(dt, noise)
        half: Array = pin.exp3(rate * (dt / 2))
        middle = self.R_world_base @ half
        gained = middle @ force + _GRAVITY
        self.position = self.position + dt * self.velocity + (dt * dt / 2) * gained
        self.velocity = self.velocity + dt * gained
        self.R_world_base = middle @ half
        self.feet = self.feet + dt * foot_velocity

    def _propagate_covariance(self, dt: float, noise: Array) -> None:
        attitude, F = self.R_world_base, self._transition
        # How a turn of the estimate, by the gyroscope's error, moves what is in the world.
        turned = self._turned
        turned[TURN] = attitude
        arms = _skew(np.vstack([self.velocity, self.position, self.feet])) @ attitude
        turned[SPEED.start : GYRO_BIAS.start], turned[FIRST_FOOT:] = arms[:6], arms[6:]
        F[:, GYRO_BIAS] = -dt * turned
        F[GYRO_BIAS, GYRO_BIAS] = np.eye(3)
        F[SPEED, TURN], F[PLACE, TURN] = dt * _SKEW_GRAVITY, (dt * dt / 2) * _SKEW_GRAVITY
        F[SPEED, ACCELERATION_BIAS], F[PLACE, SPEED] = -dt * attitude, dt * np.eye(3)
        covariance = F @ self.covariance @ F.T
        covariance += (dt * noise[0]) * (turned @ turned.T)  # attitude's, and what turns with it
        covariance.flat[SPEED.start * (len(noise) + 1) :: len(noise) + 1] += dt * noise[3:]
        self.covariance = covariance

    def plant(self, foot: int, place: Array, variance: float) -> None:
        """A foot begins to stand at a place, (3,) m in the base's frame, known to a variance."""
        at = slice(FIRST_FOOT + 3 * foot, FIRST_FOOT + 3 * foot + 3)
        self.feet[foot] = self.position + self.R_world_base @ place
        self.covariance[at], self.covariance[:, at] = 0.0, 0.0
        self.covariance[at] = self.covariance[PLACE]
        self.covariance[:, at] = self.covariance[:, PLACE]
        self.covariance[at, at] += variance * np.eye(3)

    def lift(self, foot: int) -> None:
        """A foot stands no more: its place says nothing."""
        at = slice(FIRST_FOOT + 3 * foot, FIRST_FOOT + 3 * foot + 3)
        self.covariance[at], self.covariance[:, at] = 0.0, 0.0

    def innovation(self, places: Array) -> Array:
        """(L, 3) m, world frame: where legs put the feet, (L, 3) in the base, less where they
        stand.
        """
        return places @ self.R_world_base.T + self.position - self.feet

    def surprise(self, innovation: Array, variance: float) -> Array:
        """(L,) squared innovations (L, 3) in units of what is expected, each foot by itself."""
        C, legs = self.covariance, len(innovation)
        blocks = C[FIRST_FOOT:, FIRST_FOOT:].reshape(legs, 3, legs, 3)
        own = np.arange(legs)
        across = C[PLACE, FIRST_FOOT:].reshape(3, legs, 3).transpose(1, 0, 2)
        S = C[PLACE, PLACE] + blocks[own, :, own] - across - across.transpose(0, 2, 1)
        S[:, _EACH, _EACH] += variance
        return (innovation * np.linalg.solve(S, innovation[..., None])[..., 0]).sum(axis=1)

    def correct(self, stands: BoolArray, innovation: Array, variance: float) -> None:
        """Take the places of the feet that stand, (L,), as measured with a variance, m2."""
        feet = np.flatnonzero(stands)
        if not len(feet):
            return
        rows = (FIRST_FOOT + 3 * feet[:, None] + _EACH).ravel()
        base = np.concatenate([_AXES_OF_PLACE] * len(feet))
        C = self.covariance
        across = C[:, base] - C[:, rows]  # C H^T
        S = across[base] - across[rows]
        S.flat[:: len(rows) + 1] += variance
        _, gain, failed = dposv(S, across.T)
        if failed:
            raise np.linalg.LinAlgError("the covariance of the estimate is not positive")
        self._move(-(innovation[feet].ravel() @ gain))
        covariance = C - across @ gain
        self.covariance = (covariance + covariance.T) / 2

    def _move(self, by: Array) -> None:
        """X <- exp(by) X, and biases by their part of it, (n,)."""
        turn: Array = pin.exp3(by[TURN])
        spread: Array = pin.Jexp3(-by[TURN])  # the left Jacobian
        self.R_world_base = turn @ self.R_world_base
        self.velocity = turn @ self.velocity + spread @ by[SPEED]
        self.position = turn @ self.position + spread @ by[PLACE]
        self.feet = self.feet @ turn.T + by[FIRST_FOOT:].reshape(-1, 3) @ spread.T
        self.gyro_bias = self.gyro_bias + by[GYRO_BIAS]
        self.acceleration_bias = self.acceleration_bias + by[ACCELERATION_BIAS]
