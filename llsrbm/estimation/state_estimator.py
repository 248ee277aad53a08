"""`StateEstimator`: a robot's base from its inertial unit, its joints and the feet that stand.

    estimator = StateEstimator(robot, q0)           # q0: where it stands, by definition
    q, v = estimator.update(readings, standing)     # each tick; both in Pinocchio's conventions

`standing`, (L,) bool in the order of `robot.legs`, are the feet that the controller believes to
stand and that carry load by its measured torques: `WholeBodyController.contacts.carrying` after its
last step, all of them before its first. It uses the readings' time, quaternion (the first
one only), gyroscope, accelerometer and joints.

A foot counts once it has stood for `_SETTLES`, as the ground gives way at first, and is planted
anew where it turns out to have moved. Balls roll: at lift-off of a Go2 their middles move by
11 cm/s, by what rolling leaves unexplained at 1 to 4 cm/s. A sole counts as the four balls at its
corners, each by itself, so that it tells how the base turns.

Feet that creep are the limit: on soft ground those of a front flip sink and slide by millimetres as
they take the load, unseen, and the robot jumps off with 0.1 to 0.2 m/s too much.

In flight, `standing` nowhere, gyroscope and accelerometer are integrated. An accelerometer feels
nothing in free fall, and a gyroscope's bias is known from standing, so a flight costs little: the
error of the velocity at lift-off times its duration, and its share of the turn by which the
gyroscope's scale is wrong. `benchmarks.estimator` measures both. The ground of a landing may be
anywhere, so what a flight adds to the height's error stays, as does any of place and yaw.

Joints are handed on as they were measured. The angular velocity is the gyroscope's, which is a mean
over the tick that ended and so half a tick old, and half of its last change on top: without it the
front flips of a Go2 left the ground turning up to 2 % too fast.
"""

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from llsrbm.arrays import Array, BoolArray
from llsrbm.control.readings import Readings
from llsrbm.estimation.foot_kinematics import FootKinematics
from llsrbm.estimation.invariant_filter import (
    ACCELERATION_BIAS,
    FIRST_FOOT,
    GYRO_BIAS,
    SPEED,
    TURN,
    InvariantFilter,
)
from llsrbm.mechanics import cross, yaw
from llsrbm.robots import Robot

# Standard deviations of what the filter believes; it is told nothing of the simulation.
_TILT, _UNIT_TILT = 0.004, 0.01  # rad, as it begins: by the feet, by the unit
_VELOCITY = 0.05  # m/s, likewise
_BIASES = 0.005, 0.05  # rad/s, m/s2, likewise
_GYRO, _ACCELERATION = 5e-4, 0.005  # rad/s, m/s2 over Hz^0.5: a unit's, and what shakes it
_GYRO_SCALE = 0.003 * 0.3  # share of the rate, s^0.5: a scale that is wrong for a flight's length
_WALKS = 1e-4, 1e-3  # rad/s^1.5, m/s^2.5, of the biases
_CREEP = 0.001  # m/s^0.5: of a foot that stands: ground and rubber that give way
_SLIP = 0.1  # s^0.5: likewise, of a ball that rolls, as a share of its speed
_SETTLES = 0.05  # s: sooner after a landing feet slide and sink by centimetres a second
_PLACE = 0.002  # m: of a foot in the base, by encoders and their zeros
_MOVED = 16.0  # squared standard deviations, which 1 in 1000 of feet that stand exceeds
_PLANE = 0.02  # m: points closer to a line than that span none
_UP = np.array([0.0, 0.0, 1.0])
_BOTH_BIASES = slice(GYRO_BIAS.start, ACCELERATION_BIAS.stop)


class StateEstimator:
    """Estimates q (nq,) and v (nv,) of a robot that stands in `q0` (nq,) at first.

    The world is where `q0` has the robot: its heading, and the ground that its feet stand on.
    """

    def __init__(self, robot: Robot, q0: Array) -> None:
        self.feet = FootKinematics(robot)
        self.filter = InvariantFilter(len(self.feet.position))
        self.feet.update(q0[7:], np.zeros(len(q0) - 7))
        self._quat_start = q0[[6, 3, 4, 5]]
        R_start = pin.Quaternion(q0[3:7]).toRotationMatrix()
        self._feet_start = q0[:3] + self.feet.position @ R_start.T
        self._q = q0.copy()
        self._planted: BoolArray = np.zeros(len(self.feet.position), dtype=bool)
        self._stands_since = np.full(len(self.feet.position), np.nan)  # s; nan: it does not
        self._time: float | None = None
        self._noise = np.zeros(len(self.filter.covariance))
        self._begins = True
        self._gyro_before = np.zeros(3)

    def restart(self) -> None:
        """The next readings are of `q0` again, perhaps moving; biases stay as they are known."""
        self._begins = True

    def update(self, readings: Readings, standing: BoolArray) -> tuple[Array, Array]:
        """The estimate at the time of the readings; `standing`: (L,), see above."""
        self.feet.update(readings.q, readings.dq)
        standing = standing.repeat(self.feet.points)
        if self._begins or self._time is None:
            self._begin(readings, standing)
        else:
            self._go_on(readings, readings.time - self._time, standing)
        if self._begins:
            self._gyro_before = readings.gyro
        self._begins, self._time = False, readings.time
        return self._estimate(readings)

    def _begin(self, readings: Readings, standing: BoolArray) -> None:
        belief, feet = self.filter, self.feet
        stands = standing if standing.any() else np.ones(len(standing), dtype=bool)
        attitude, tilt = self._attitude_start(readings.quat, stands)
        belief.R_world_base = attitude
        places = feet.position @ attitude.T
        belief.position = (self._feet_start - places)[stands].mean(axis=0)
        rate = readings.gyro - belief.gyro_bias
        moving = self._rolling(rate) - self._swept(rate) @ attitude.T
        belief.velocity = moving[stands].mean(axis=0)
        if self._time is None:
            biases = np.diag(np.repeat(np.square(_BIASES), 3))
        else:
            biases = belief.covariance[_BOTH_BIASES, _BOTH_BIASES]
        variances = np.zeros(len(self._noise))
        variances[TURN], variances[SPEED] = [tilt**2, tilt**2, 0.0], _VELOCITY**2
        belief.covariance = np.diag(variances)
        belief.covariance[_BOTH_BIASES, _BOTH_BIASES] = biases
        self._planted = standing.copy()
        self._stands_since = np.where(standing, -np.inf, np.nan)
        for foot in np.flatnonzero(standing).tolist():
            belief.plant(foot, feet.position[foot], _PLACE**2)

    def _attitude_start(self, quat: Array, stands: BoolArray) -> tuple[Array, float]:
        """R_world_base (3, 3) as a start, and how well its tilt is known, rad.

        By the feet, which stand on the ground of `q0`: the unit's tilt is wrong by its
        accelerometer's bias, 5 mrad. Two points say nothing of a tilt about their line.
        """
        arms, wanted = (
            points[stands] - points[stands].mean(axis=0)
            for points in (self.feet.position, self._feet_start)
        )
        if np.linalg.matrix_rank(wanted, tol=_PLANE) > 1:
            return Rotation.align_vectors(wanted, arms)[0].as_matrix(), _TILT
        w, x, y, z = quat
        unit = pin.Quaternion(w, x, y, z).toRotationMatrix()
        heading, has = yaw(np.array([self._quat_start, quat]))
        return pin.utils.rotate("z", heading - has) @ unit, _UNIT_TILT

    def _go_on(self, readings: Readings, dt: float, standing: BoolArray) -> None:
        belief, feet = self.filter, self.feet
        rate = readings.gyro - belief.gyro_bias
        rolling = self._rolling(rate)
        noise = self._noise_of(rate, rolling)
        belief.propagate(dt, readings.gyro, readings.acceleration, rolling, noise)
        planted, now = self._planted, readings.time
        since = np.where(np.isnan(self._stands_since), now, self._stands_since)
        self._stands_since = np.where(standing, since, np.nan)
        settled = self._stands_since < now - _SETTLES
        for foot in np.flatnonzero(planted & ~settled).tolist():
            belief.lift(foot)
        known = planted & settled
        moved = known
        if known.any():
            innovation = belief.innovation(feet.position)
            moved = known & (belief.surprise(innovation, _PLACE**2) > _MOVED)
            belief.correct(known & ~moved, innovation, _PLACE**2)
        for foot in np.flatnonzero(moved | (settled & ~planted)).tolist():
            belief.plant(foot, feet.position[foot], _PLACE**2)
        self._planted = settled

    def _noise_of(self, rate: Array, rolling: Array) -> Array:
        """(n,) variances a second: see `InvariantFilter.propagate`."""
        noise = self._noise
        noise[TURN] = _GYRO**2 + _GYRO_SCALE**2 * rate.dot(rate)
        noise[SPEED] = _ACCELERATION**2
        noise[GYRO_BIAS], noise[ACCELERATION_BIAS] = np.square(_WALKS)
        creep = _CREEP**2 + _SLIP**2 * (rolling * rolling).sum(axis=1)
        noise[FIRST_FOOT:] = np.where(self._planted, creep, 0.0).repeat(3)
        return noise

    def _swept(self, rate: Array) -> Array:
        """(L c, 3) m/s, base frame: the balls' middles by joints and by the base's turning."""
        return self.feet.velocity + cross(rate[None], self.feet.position)

    def _rolling(self, rate: Array) -> Array:
        """(L c, 3) m/s, world frame: of the middles of balls that roll."""
        turning = (self.feet.angular_velocity + rate) @ self.filter.R_world_base.T
        return cross(turning, self.feet.radius * _UP[None])

    def _rate_now(self, gyro: Array) -> Array:
        """(3,) rad/s as the tick ends, of means over ticks: on half the way that they changed."""
        now: Array = gyro + (gyro - self._gyro_before) / 2
        self._gyro_before = gyro
        return now

    def _estimate(self, readings: Readings) -> tuple[Array, Array]:
        belief = self.filter
        quat = pin.Quaternion(belief.R_world_base).normalized().coeffs()
        q = np.concatenate(
            [belief.position, quat if quat @ self._q[3:7] >= 0 else -quat, readings.q]
        )
        v = np.concatenate(
            [
                belief.R_world_base.T @ belief.velocity,
                self._rate_now(readings.gyro) - belief.gyro_bias,
                readings.dq,
            ]
        )
        self._q = q
        return q, v
