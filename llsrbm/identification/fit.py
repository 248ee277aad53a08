"""Drives from a log: least squares in what is linear, a search in the delay.

    tau(t - delay) = rnea(q, q', q'')_joint + I q'' + F sign(q') + D q' + offset

with the links' inverse dynamics alone. Every term goes through the same two Gaussian filters, so
that none is early or small against another: the first makes q'' and the sign of q' known, the
second takes the noise. As a joint turns about, friction is anything between its two values: what a
filter sees of that is left out.

Encoders' zeros come first. One that is off by z changes what gravity and inertia ask of the joints
around it: by -(d tau / d q) z, which all joints' equations tell together, by least squares of what
their drives' own numbers leave. Positions are corrected by them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar, nnls

from llsrbm.arrays import Array, IntArray
from llsrbm.errors import InputError
from llsrbm.identification.log import Log
from llsrbm.identification.signals import CUT, LONGEST, Signals, smoothed
from llsrbm.identification.units import check_units
from llsrbm.robots import Robot

NAMES = ("armature", "friction", "damping")

# Of the second; of each joint the longest that leaves enough, as noise falls with its power 1.5.
_SECOND = (LONGEST, 0.014, 0.01, 0.007)
_FAST = 2.0  # times that: reached by a tenth of what is used, or the joint creeps against stiction
_LEAKS = 0.05  # share of what must not enter, that a filter may see
_OUTLIER = 5.0  # robust standard deviations: links or ropes touched
_ENOUGH, _LEAST = 60.0, 25.0  # independent samples
_ALIKE = 60.0  # condition number of columns of unit length
_UNKNOWN = 0.3  # share of the armature; an error above it is no measurement
_UNEXPLAINED = 0.08  # share of a drive's own torque; more is no drive's
_DELAYS = (-0.004, 0.03)  # s
_STEP = 5e-4  # s
_ZERO = 0.005  # rad or m, standard deviation of encoders' zeros before anything is measured


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
        zeros, zero_errors: (J,) rad or m that positions in the log are too large, and their
            standard errors.
        delay, delay_error: s from a row's time until the torque acts that is commanded in it.
        speed_lag: s by which the log's speeds are behind the change of its positions.
        time: (K,) s; measured, modelled: (K, J) Nm of all joints, NaN of those not determined.
    """

    log: Log
    joints: dict[str, JointDrive]
    undetermined: dict[str, str]
    zeros: Array
    zero_errors: Array
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
    check_units(robot, log)
    signals = Signals(robot, log)
    zeros, zero_errors = _zeros(signals, *_columns(signals)[:2])
    signals = Signals(robot, replace(log, q=log.q - zeros))
    columns, delay, undetermined = _columns(signals)
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
    measured, modelled = _torques(signals, joints, delay)
    return Identified(
        log,
        joints,
        undetermined,
        zeros,
        zero_errors,
        delay + signals.lead,
        delay_error,
        signals.speed_lag,
        signals.time,
        measured,
        modelled,
    )


def _columns(signals: Signals) -> tuple[list[_Column], float, dict[str, str]]:
    """The joints' equations, the delay, s, and of joints that have none, why."""
    columns: list[_Column] = []
    undetermined: dict[str, str] = {}
    for joint, name in enumerate(signals.robot.joint_names):
        found = _column(signals, joint)
        if isinstance(found, str):
            undetermined[name] = found
        else:
            columns.append(found)
    if not columns:
        return columns, 0.0, undetermined
    delay = _delay(columns)
    columns = [column.without_outliers(delay) for column in columns]
    return columns, _delay(columns), undetermined


def _zeros(signals: Signals, columns: list[_Column], delay: float) -> tuple[Array, Array]:
    """(J,) rad or m that the log's positions are too large, and their standard errors."""
    by_zero = -signals.slopes()
    precision = np.eye(by_zero.shape[1]) / _ZERO**2
    information = np.zeros(len(precision))
    for column in columns:
        own = smoothed(by_zero[:, column.joint], column.second / signals.period)
        beside = column.beside(own[column.rows])
        precision += beside.T @ beside / column.variance(delay)
        information += beside.T @ column.residual(delay) / column.variance(delay)
    covariance = np.linalg.inv(precision)
    return covariance @ information, np.sqrt(np.diag(covariance))


def _torques(signals: Signals, joints: dict[str, JointDrive], delay: float) -> tuple[Array, Array]:
    """(K, J) Nm, measured and modelled; NaN of joints that are not among these."""
    measured, modelled = np.full((2, *signals.q.shape), np.nan)
    shifted = CubicSpline(signals.time, signals.sent)(signals.time - delay - signals.period / 2)
    for k, name in enumerate(signals.robot.joint_names):
        if (drive := joints.get(name)) is not None:
            measured[:, k] = shifted[:, k] - signals.feedback[:, k]
            modelled[:, k] = (
                signals.links[:, k]
                + drive.armature * signals.ddq[:, k]
                + drive.friction * signals.direction[:, k]
                + drive.damping * signals.dq[:, k]
                + drive.offset
            )
    return measured, modelled


@dataclass(frozen=True, eq=False)
class _Column:
    """The equations of one joint, N of them.

    Attributes:
        X: (N, 4) of q'', sign of q', q' and 1; links: (N,) Nm that links and feedback take.
        sent: commanded torque at a time; times: (N,) s, of the middle of what is held then.
        rows: (N,) of the log; second: s, standard deviation of the second filter.
        independent: how many of the equations are independent of each other.
    """

    joint: int
    X: Array
    links: Array
    sent: CubicSpline
    times: Array
    rows: IntArray
    second: float
    independent: float

    @cached_property
    def _basis(self) -> Array:
        return np.linalg.qr(self.X)[0]

    def torque(self, delay: float) -> Array:
        """(N,) Nm that the drive itself takes."""
        return self.sent(self.times - delay) - self.links

    def residual(self, delay: float) -> Array:
        """(N,) Nm that nothing explains."""
        return self.beside(self.torque(delay))

    def slope(self, delay: float) -> Array:
        """(N,) Nm/s by which the residual changes with the delay."""
        return self.beside(-self.sent(self.times - delay, 1))

    def beside(self, values: Array) -> Array:
        """(N, ...) of it what the drive's own numbers cannot explain."""
        return values - self._basis @ (self._basis.T @ values)

    def variance(self, delay: float) -> float:
        """Nm2 of a residual, times how many equations one independent one stands for."""
        r = self.residual(delay)
        return float(r @ r) / max(self.independent - self.X.shape[1], 1.0)

    def without_outliers(self, delay: float) -> _Column:
        """The equations that the rest explains."""
        size = np.abs(self.residual(delay))
        kept = size < _OUTLIER * 1.4826 * max(float(np.median(size)), 1e-12)
        share = float(kept.mean())
        return replace(
            self,
            X=self.X[kept],
            links=self.links[kept],
            times=self.times[kept],
            rows=self.rows[kept],
            independent=share * self.independent,
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


def _column(signals: Signals, joint: int) -> _Column | str:
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


def _filtered(signals: Signals, joint: int, second: float) -> _Column:
    period = signals.period
    deviation = second / period
    edge = int(np.ceil(CUT * (second + signals.first) / period + _DELAYS[1] / period))
    every = slice(edge, max(edge, len(signals.q) - edge), max(1, int(deviation / 2)))

    def through(values: Array) -> Array:
        return smoothed(values[:, joint].astype(float), deviation)

    kept = through(signals.out)[every] < _LEAKS
    time = signals.time[every][kept]
    columns = [through(each)[every][kept] for each in (signals.ddq, signals.direction, signals.dq)]
    both = float(np.hypot(second, signals.first))
    return _Column(
        joint,
        np.column_stack([*columns, np.ones(len(time))]),
        through(signals.links + signals.feedback)[every][kept],
        CubicSpline(signals.time, through(signals.sent)),
        np.asarray(time - period / 2),  # a command is held until the next
        np.arange(len(signals.q))[every][kept],
        second,
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
