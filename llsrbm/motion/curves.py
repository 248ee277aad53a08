"""Smooth curves over N intervals between a plan's knots: of places, and of attitudes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from llsrbm.arrays import Array, IntArray
from llsrbm.mechanics import cross


@dataclass(frozen=True, eq=False)
class Polynomials:
    """One an interval, of the share (0 to 1) of it that has passed.

    Attributes:
        coefficients: (N, d, ...), of rising powers.
        dt: (N,) s.
    """

    coefficients: Array
    dt: Array

    @staticmethod
    def cubics(values: Array, slopes: Array, dt: Array) -> Polynomials:
        """Through values (N + 1, ...) with slopes (N + 1, ...), per s, at the knots."""
        return Polynomials.between(np.diff(values, axis=0), slopes[:-1], slopes[1:], dt).plus(
            values[:-1]
        )

    @staticmethod
    def between(rise: Array, first: Array, last: Array, dt: Array) -> Polynomials:
        """Cubics from 0 to `rise` (N, ...), with slopes (N, ...), per s, at both ends."""
        span = dt.reshape(-1, *[1] * (rise.ndim - 1))
        first, last = span * first, span * last
        cubic = [0 * rise, first, 3 * rise - 2 * first - last, first + last - 2 * rise]
        return Polynomials(np.stack(cubic, axis=1), dt)

    def plus(self, values: Array) -> Polynomials:
        """With constants (N, ...) added."""
        known = self.coefficients.copy()
        known[:, 0] += values
        return Polynomials(known, self.dt)

    def __add__(self, other: Polynomials) -> Polynomials:
        one, two = sorted((self.coefficients, other.coefficients), key=lambda c: c.shape[1])
        total = two.copy()
        total[:, : one.shape[1]] += one
        return Polynomials(total, self.dt)

    def at(self, k: IntArray, share: Array) -> Array:
        """(K, ...) at shares (K,) of intervals (K,)."""
        known = self.coefficients[k]
        powers = share[:, None] ** np.arange(known.shape[1])
        return np.einsum("kd,kd...->k...", powers, known)

    def slopes(self, k: IntArray, share: Array) -> Array:
        """(K, ...) per s."""
        known = self.coefficients[k, 1:]
        orders = np.arange(1, known.shape[1] + 1)
        powers = orders * share[:, None] ** (orders - 1) / self.dt[k][:, None]
        return np.einsum("kd,kd...->k...", powers, known)


@dataclass(frozen=True, eq=False)
class Turns:
    """Attitudes that turn from the start of each interval by a rotation vector.

    Attributes:
        start: (N, ..., 4) w, x, y, z.
        vector: (N, d, ..., 3) rad, in the turned body's axes.
    """

    start: Array
    vector: Polynomials

    @staticmethod
    def through(quat: Array, rate: Array, dt: Array) -> Turns:
        """Through attitudes (N + 1, ..., 4) with rates (N + 1, ..., 3) rad/s in their own axes."""
        turn = turns(quat)
        last = slope_of(turn, rate[1:])
        return Turns(quat[:-1], Polynomials.between(turn, rate[:-1], last, dt))

    def at(self, k: IntArray, share: Array) -> tuple[Array, Array]:
        """Attitudes (K, ..., 4) and rates (K, ..., 3) rad/s in their own axes."""
        turn, slope, start = self.vector.at(k, share), self.vector.slopes(k, share), self.start[k]
        turned = _rotation(start) * Rotation.from_rotvec(turn.reshape(-1, 3))
        return turned.as_quat(scalar_first=True).reshape(start.shape), _rate_of(turn, slope)


def turns(quat: Array) -> Array:
    """Rotation vectors (N, ..., 3) rad from each of (N + 1, ..., 4) to the next, in its axes."""
    turn = (_rotation(quat[:-1]).inv() * _rotation(quat[1:])).as_rotvec()
    return turn.reshape(*quat[1:].shape[:-1], 3)


def slope_of(turn: Array, rate: Array) -> Array:
    """Derivative of a rotation vector (..., 3) rad, of the body's rate in its own axes, rad/s."""
    angle = np.sqrt(_square(turn))
    tiny = angle < 1e-3
    safe = np.where(tiny, 1.0, angle)
    twice = np.where(tiny, 1 / 12, (1 - safe / 2 / np.tan(safe / 2)) / safe**2)
    turned: Array = cross(turn, rate)
    return rate + turned / 2 + twice * cross(turn, turned)


def _rate_of(turn: Array, slope: Array) -> Array:
    """The inverse of `slope_of`, exactly."""
    angle = np.sqrt(_square(turn))
    tiny = angle < 1e-3
    safe = np.where(tiny, 1.0, angle)
    once = np.where(tiny, 0.5, (1 - np.cos(angle)) / safe**2)
    twice = np.where(tiny, 1 / 6, (safe - np.sin(safe)) / safe**3)
    turned: Array = cross(turn, slope)
    return slope - once * turned + twice * cross(turn, turned)


def _square(vector: Array) -> Array:
    return np.sum(vector**2, axis=-1, keepdims=True)


def _rotation(quat: Array) -> Rotation:
    return Rotation.from_quat(quat.reshape(-1, 4), scalar_first=True)
