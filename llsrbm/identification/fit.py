"""Drives from a log: least squares in what is linear, a search in the delay.

    tau(t - delay) = rnea(q, q', q'')_joint + I q'' + F sign(q') + D q' + offset

with the links' inverse dynamics alone. Every term goes through the same two Gaussian filters, so
that none is early or small against another: the first makes q'' and the sign of q' known, the
second takes the noise. As a joint turns about, friction is anything between its two values: what a
filter sees of that is left out. The offset is what wrong zeros of encoders leave of gravity.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d, maximum_filter1d, minimum_filter1d
from scipy.optimize import minimize_scalar, nnls

from llsrbm.errors import InputError
from llsrbm.identification.log import Log
from llsrbm.mechanics import GRAVITY
from llsrbm.robots import Robot
from llsrbm.robots.drives.torques import STILL

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

NAMES = ("armature", "friction", "damping")

_FIRST = 0.003  # s, standard deviation of the first filter
# Of the second; of each joint the longest that leaves enough, as noise falls with its power 1.5.
_SECOND = (0.02, 0.014, 0.01, 0.007)
_CUT = 8.0  # standard deviations at which filters end: at 5 a second derivative sees positions
_SLOW = STILL  # share of the speed limit below which friction is not known
_FAST = 2.0  # times that: reached by a tenth of what is used, or the joint creeps against stiction
_TURNS = 0.02  # s before and after, in which a joint that turns about has any friction
_LEAKS = 0.05  # share of what must not enter, that a filter may see
# s by which a simulator's speeds are behind its positions: half of a step of up to a millisecond.
# Then speeds tell when a torque acts. Of later speeds a drive's filter is the reason: positions do.
_HALF_STEP = 6e-4
_AT_STOP = 0.01  # rad or m
_SATURATED = 0.97  # share of the torque limit
_OUTLIER = 5.0  # robust standard deviations: links or ropes touched
_ENOUGH, _LEAST = 60.0, 25.0  # independent samples
_ALIKE = 60.0  # condition number of columns of unit length
_UNKNOWN = 0.3  # share of the armature; an error above it is no measurement
_UNEXPLAINED = 0.08  # share of a drive's own torque; more is no drive's
_DELAYS = (-0.004, 0.03)  # s
_STEP = 5e-4  # s


@dataclass(frozen=True)
class JointDrive:
    """One joint's drive, with standard errors: kg m2, Nm, Nm s/rad (kg, N, N s/m)."""

    armature: float
    friction: float
    damping: float
    armature_error: float
    friction_error: float
    damping_error: float
    offset: float  # Nm
    residual: float  # Nm RMS, of filtered torques


@dataclass(frozen=True, eq=False)
class Identified:
    """Drives of a robot as a log shows them.

    Attributes:
        joints: joint name -> its drive; undetermined: of the others, why.
        delay, delay_error: s from a row's time until the torque acts that is commanded in it.
        speed_lag: s by which the log's speeds are behind the change of its positions.
        time: (K,) s; measured, modelled: (K, J) Nm of all joints, NaN of those not determined.
    """

    log: Log
    joints: dict[str, JointDrive]
    undetermined: dict[str, str]
    delay: float
    delay_error: float
    speed_lag: float
    time: Array
    measured: Array
    modelled: Array


def identify(robot: Robot, log: Log) -> Identified:
    """The drives of a robot from a log. Raises `InputError`: it determines no joint."""
    if not log.usable.any():
        raise InputError(
            f"{log.name}: nothing in it is of joints in the air; expected a log of `llsrbm deploy "
            "--excite`, or a flight"
        )
    signals = _Signals(robot, log)
    columns: list[_Column] = []
    undetermined: dict[str, str] = {}
    for joint, name in enumerate(robot.joint_names):
        found = _column(signals, joint)
        if isinstance(found, str):
            undetermined[name] = found
        else:
            columns.append(found)
    delay = _delay(columns) if columns else 0.0
    columns = [column.without_outliers(delay) for column in columns]
    delay = _delay(columns) if columns else 0.0
    joints = {}
    delay_error = _delay_error(columns, delay)
    for column in columns:
        name = robot.joint_names[column.joint]
        drive = column.drive(delay, delay_error)
        typical = float(np.std(column.torque(delay)))
        if drive.residual > _UNEXPLAINED * typical:
            undetermined[name] = (
                f"{drive.residual:.2g} of {typical:.2g} Nm are not explained, as if links touched "
                "or masses were others"
            )
        elif drive.armature_error > _UNKNOWN * drive.armature:
            undetermined[name] = (
                f"its armature, {drive.armature:.2g} +- {drive.armature_error:.2g}, is not known "
                "from so little acceleration"
            )
        else:
            joints[name] = drive
    if not joints:
        name, why = next(iter(undetermined.items()))
        raise InputError(f"{log.name}: no joint's drive can be told from it; {name}: {why}")
    measured, modelled = signals.torques(joints, delay)
    return Identified(
        log,
        joints,
        undetermined,
        delay + signals.lead,
        delay_error,
        signals.speed_lag,
        signals.time,
        measured,
        modelled,
    )


class _Signals:
    """A log's signals after the first filter, in which all else is computed."""

    def __init__(self, robot: Robot, log: Log) -> None:
        self.robot, self.log, self.period = robot, log, log.period
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
        deviation = _SECOND[0] / self.period
        dq, by_q = (smoothed(each, deviation) for each in (self.dq, self._first(self.log.q, 1)))
        change = smoothed(self._first(self.log.q, 2), deviation)
        inside = slice(round(_CUT * deviation), -round(_CUT * deviation))
        spread = np.maximum(np.sum((change**2)[inside], axis=0), 1e-12)
        lags = np.sum(((by_q - dq) * change)[inside], axis=0) / spread
        return float(np.average(lags, weights=spread))

    def _positions_are_better(self) -> bool:
        """Whether accelerations from positions have less noise than those from speeds."""
        deviation = _SECOND[0] / self.period
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
        return smoothed(values, _FIRST / self.period, derivative) / self.period**derivative

    def _inverse_dynamics(self) -> Array:
        """(K, J) Nm that the links take, by what the base's inertial unit feels."""
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
        found = np.empty_like(self.q)
        for k in range(count):
            q[7:], v[6:], a[6:] = self.q[k], self.dq[k], self.ddq[k]
            v[3:6], a[:6] = base[k, :3], base[k, 3:]
            found[k] = pin.rnea(model, data, q, v, a)[6:]
        return found

    def torques(self, joints: dict[str, JointDrive], delay: float) -> tuple[Array, Array]:
        """(K, J) Nm, measured and modelled; NaN of joints that are not among these."""
        measured, modelled = np.full((2, *self.q.shape), np.nan)
        shifted = CubicSpline(self.time, self.sent)(self.time - delay - self.period / 2)
        for k, name in enumerate(self.robot.joint_names):
            if (drive := joints.get(name)) is not None:
                measured[:, k] = shifted[:, k] - self.feedback[:, k]
                modelled[:, k] = (
                    self.links[:, k]
                    + drive.armature * self.ddq[:, k]
                    + drive.friction * self.direction[:, k]
                    + drive.damping * self.dq[:, k]
                    + drive.offset
                )
        return measured, modelled


def smoothed(values: Array, deviation: float, derivative: int = 0) -> Array:
    """(K, ...) through a Gaussian filter of a standard deviation in rows, or its derivative."""
    filtered: Array = gaussian_filter1d(values, deviation, axis=0, order=derivative, truncate=_CUT)
    return filtered


@dataclass(frozen=True, eq=False)
class _Column:
    """The equations of one joint, N of them.

    Attributes:
        X: (N, 4) of q'', sign of q', q' and 1; links: (N,) Nm that links and feedback take.
        sent: commanded torque at a time; times: (N,) s, of the middle of what is held then.
        independent: how many of the equations are independent of each other.
    """

    joint: int
    X: Array
    links: Array
    sent: CubicSpline
    times: Array
    independent: float

    @cached_property
    def _basis(self) -> Array:
        basis: Array = np.linalg.qr(self.X)[0]
        return basis

    def torque(self, delay: float) -> Array:
        """(N,) Nm that the drive itself takes."""
        torque: Array = self.sent(self.times - delay) - self.links
        return torque

    def residual(self, delay: float) -> Array:
        """(N,) Nm that nothing explains."""
        return self._beside(self.torque(delay))

    def slope(self, delay: float) -> Array:
        """(N,) Nm/s by which the residual changes with the delay."""
        return self._beside(-self.sent(self.times - delay, 1))

    def _beside(self, values: Array) -> Array:
        beside: Array = values - self._basis @ (self._basis.T @ values)
        return beside

    def variance(self, delay: float) -> float:
        """Nm2 of a residual, times how many equations one independent one stands for."""
        r = self.residual(delay)
        return float(r @ r) / max(self.independent - self.X.shape[1], 1.0)

    def without_outliers(self, delay: float) -> _Column:
        """The equations that the rest explains."""
        size = np.abs(self.residual(delay))
        kept = size < _OUTLIER * 1.4826 * max(float(np.median(size)), 1e-12)
        share = float(kept.mean())
        return _Column(
            self.joint,
            self.X[kept],
            self.links[kept],
            self.sent,
            self.times[kept],
            share * self.independent,
        )

    def drive(self, delay: float, delay_error: float) -> JointDrive:
        """Least squares of the drive's numbers, none negative."""
        y, X = self.torque(delay), self.X
        # The offset has either sign.
        found = nnls(np.column_stack([X, -X[:, 3]]), y)[0]
        normal = np.linalg.inv(X.T @ X)
        by_delay = normal @ (X.T @ -self.sent(self.times - delay, 1))
        covariance = self.variance(delay) * normal
        covariance += delay_error**2 * np.outer(by_delay, by_delay)
        errors = np.sqrt(np.diag(covariance))
        r = y - X[:, :3] @ found[:3] - (found[3] - found[4]) * X[:, 3]
        return JointDrive(
            *map(float, (*found[:3], *errors[:3], found[3] - found[4], np.sqrt(np.mean(r**2))))
        )


def _column(signals: _Signals, joint: int) -> _Column | str:
    """The equations of a joint, by the longest filter that leaves enough; or why there are none."""
    if not signals.moving[joint]:
        return "it does not move"
    for second in _SECOND:
        found = _filtered(signals, joint, second)
        if found.independent >= _ENOUGH:
            break
    if found.independent < _LEAST:
        return "it rests, turns about or is at a limit all the time"
    fast = float(np.quantile(np.abs(found.X[:, 2]), 0.9))
    if fast < _FAST * signals.slow[joint]:
        return f"it hardly moves faster than a joint that sticks, {fast:.2g} rad/s"
    scaled = found.X / np.linalg.norm(found.X, axis=0)
    if np.linalg.cond(scaled) > _ALIKE:
        return "its motion does not tell armature, friction and damping apart"
    return found


def _filtered(signals: _Signals, joint: int, second: float) -> _Column:
    period = signals.period
    deviation = second / period
    edge = int(np.ceil(_CUT * (second + _FIRST) / period + _DELAYS[1] / period))
    every = slice(edge, max(edge, len(signals.q) - edge), max(1, int(deviation / 2)))

    def through(values: Array) -> Array:
        return smoothed(values[:, joint].astype(float), deviation)

    kept = through(signals.out)[every] < _LEAKS
    time = signals.time[every][kept]
    columns = [through(each)[every][kept] for each in (signals.ddq, signals.direction, signals.dq)]
    both = float(np.hypot(second, _FIRST))
    return _Column(
        joint,
        np.column_stack([*columns, np.ones(len(time))]),
        through(signals.links + signals.feedback)[every][kept],
        CubicSpline(signals.time, through(signals.sent)),
        np.asarray(time - period / 2),  # a command is held until the next
        len(time) * every.step * period / (2 * np.sqrt(np.pi) * both),
    )


def _delay(columns: list[_Column]) -> float:
    """S by which all joints' torques fit best, each weighted by its own residual."""

    def cost(delay: float) -> float:
        return sum(c.independent * np.log(c.variance(delay) + 1e-18) for c in columns)

    coarse = np.arange(*_DELAYS, _STEP)
    best = coarse[int(np.argmin([cost(delay) for delay in coarse]))]
    around = (best - 1.2 * _STEP, best + 1.2 * _STEP)
    found = minimize_scalar(cost, bounds=around, method="bounded", options={"xatol": 1e-7})
    return float(found.x)


def _delay_error(columns: list[_Column], delay: float) -> float:
    """Standard error of the delay, s."""
    known = sum(float(np.sum(c.slope(delay) ** 2)) / c.variance(delay) for c in columns)
    return float(1.0 / np.sqrt(known)) if known > 0 else np.inf
