"""A log's signals as drives are told from them: filtered, with what the links take."""

from collections.abc import Iterator

import numpy as np
import pinocchio as pin
from scipy.ndimage import gaussian_filter1d, maximum_filter1d, minimum_filter1d

from llsrbm.arrays import Array
from llsrbm.identification.log import Log
from llsrbm.mechanics import GRAVITY
from llsrbm.robots import Robot
from llsrbm.robots.drives.torques import STILL

FIRST = 0.003  # s, standard deviation of the first filter; a row at least, or it is no derivative
LONGEST = 0.02  # s, likewise, of the second at most
CUT = 8.0  # standard deviations at which filters end: at 5 a second derivative sees positions
_SLOW = STILL  # share of the speed limit below which friction is not known
_TURNS = 0.02  # s before and after, in which a joint that turns about has any friction
# s by which a simulator's speeds are behind its positions: half of a step of up to a millisecond.
# Then speeds tell when a torque acts. Of later speeds a drive's filter is the reason: positions do.
_HALF_STEP = 6e-4
_AT_STOP = 0.01  # rad or m
_SATURATED = 0.97  # share of the torque limit


class Signals:
    """A log's signals after the first filter, in which all else is computed."""

    def __init__(self, robot: Robot, log: Log) -> None:
        self.robot, self.log, self.period = robot, log, log.period
        self.first = max(FIRST, log.period)
        self.time: Array = log.period * np.arange(len(log.q), dtype=np.float64)
        self.q, self.dq, self.ddq = self._first(log.q), self._first(log.dq), self._first(log.dq, 1)
        self.speed_lag = self._speed_lag()
        if self._positions_are_better():
            self.dq, self.ddq = self._first(log.q, 1), self._first(log.q, 2)
            self.lead = self.speed_lag if self.speed_lag < _HALF_STEP else 0.0
        else:
            self.lead = 0.0 if self.speed_lag < _HALF_STEP else -self.speed_lag
        self.sent, self.feedback = self._first(log.sent), self._first(log.feedback)
        self.direction = np.tanh(self.dq / (0.1 * STILL * robot.speed_limit))
        self.links = self._inverse_dynamics()
        self.moving = np.abs(self.dq).max(axis=0) > self.slow
        # What must not enter: joints that turn about, stops, full torque, gaps.
        window = 2 * round(_TURNS / log.period) + 1
        lowest, highest = (f(self.dq, window, axis=0) for f in (minimum_filter1d, maximum_filter1d))
        lower, upper = robot.joint_stops
        self.out = (lowest < self.slow) & (highest > -self.slow)
        self.out |= (log.q < lower + _AT_STOP) | (log.q > upper - _AT_STOP)
        self.out |= np.abs(log.sent - log.feedback) > _SATURATED * robot.torque_limit
        self.out |= ~log.usable[:, None]

    @property
    def slow(self) -> Array:
        """(J,) rad/s below which friction is not known."""
        return _SLOW * self.robot.speed_limit

    def _speed_lag(self) -> float:
        """S by which the log's speeds are behind the change of its positions."""
        deviation = LONGEST / self.period
        dq, by_q = (smoothed(each, deviation) for each in (self.dq, self._first(self.log.q, 1)))
        change = smoothed(self._first(self.log.q, 2), deviation)
        inside = slice(round(CUT * deviation), -round(CUT * deviation))
        spread = np.maximum(np.sum((change**2)[inside], axis=0), 1e-12)
        lags = np.sum(((by_q - dq) * change)[inside], axis=0) / spread
        return float(np.average(lags, weights=spread))

    def _positions_are_better(self) -> bool:
        """Whether accelerations from positions have less noise than those from speeds."""
        deviation = LONGEST / self.period
        # Of white noise of a row, the share in a Gaussian's second and first derivative.
        shares = (
            np.sqrt(0.75) / deviation**2 / self.period**2,
            np.sqrt(0.5) / deviation / self.period,
        )
        noise = [
            np.median(np.std(np.diff(each, n=3, axis=0), axis=0))
            for each in (self.log.q, self.log.dq)
        ]
        return bool(noise[0] * shares[0] < noise[1] * shares[1])

    def _first(self, values: Array, derivative: int = 0) -> Array:
        return smoothed(values, self.first / self.period, derivative) / self.period**derivative

    def slopes(self) -> Array:
        """(K, J, J) Nm/rad by which what the links take changes with the joints' positions."""
        joints = self.q.shape[1]
        found = np.empty((len(self.q), joints, joints))
        for k, (model, data, state) in enumerate(self._states()):
            pin.computeRNEADerivatives(model, data, *state)
            found[k] = data.dtau_dq[6:, 6:]
        return found

    def _inverse_dynamics(self) -> Array:
        """(K, J) Nm that the links take."""
        found = np.empty_like(self.q)
        for k, (model, data, state) in enumerate(self._states()):
            found[k] = pin.rnea(model, data, *state)[6:]
        return found

    def _states(self) -> Iterator[tuple[pin.Model, pin.Data, tuple[Array, Array, Array]]]:
        """The links' model and q, v, a of each row, the base by what its inertial unit feels."""
        model = self.robot.model.copy()
        model.armature[:] = 0.0
        # Instead, the base accelerates by what the inertial unit shows: it feels no gravity.
        model.gravity = pin.Motion.Zero()
        data, count = model.createData(), len(self.q)
        base = np.zeros((count, 9))
        base[:, 5] = GRAVITY
        if self.log.gyro is not None and self.log.acceleration is not None:
            base[:, :3], base[:, 3:6] = map(self._first, (self.log.gyro, self.log.acceleration))
            base[:, 6:] = self._first(self.log.gyro, 1)
        q, v, a = pin.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
        for k in range(count):
            q[7:], v[6:], a[6:] = self.q[k], self.dq[k], self.ddq[k]
            v[3:6], a[:6] = base[k, :3], base[k, 3:]
            yield model, data, (q, v, a)


def smoothed(values: Array, deviation: float, derivative: int = 0) -> Array:
    """(K, ...) through a Gaussian filter of a standard deviation in rows, or its derivative."""
    return gaussian_filter1d(values, deviation, axis=0, order=derivative, truncate=CUT)
