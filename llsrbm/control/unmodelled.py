"""Accelerations that come beside those that commands were made for.

Rotors that are heavier than a file says, friction that is more or less, stiction: they move joints and
base, tick after tick, to the same side. What is measured less what the acting commands expected,

    d += (dv/dt - a_expected) / `MEMORY` dt,    a_expected = a of the program + d,

is what the next program leaves out of what it asks for: the integral part of the tasks' feedback.
Unlike integrated errors d does not grow while drives or friction cannot give what is wanted.
"""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MEMORY = float(os.environ.get("OBS", "0.03"))  # s; in less, noise of measured velocities comes through
SETTLING = float(os.environ.get("SETTLE", "0.05"))  # s after feet have landed or left, in which contacts decide
MOST=float(os.environ.get("MOSTOBS","1e9"))

class Unmodelled:
    """d (n,) rad/s2 or m/s2, by the ticks of a controller, s."""

    def __init__(self, tick: float, velocities: int) -> None:
        self._tick = tick
        self._last: Array | None = None  # (n,) measured velocities
        self._standing: bytes = b""
        self._wait = 0
        self.acceleration = np.zeros(velocities)

    def measured(self, v: Array, expected: Array | None, standing: NDArray[np.bool_]) -> None:
        """Take velocities (n,), measured as a tick ends, accelerations (n,) that were expected of
        it, None: unknown, and which feet (L,) stand.
        """
        last, self._last = self._last, v
        if (now := standing.tobytes()) != self._standing:
            if self._standing: self._wait = round(SETTLING / self._tick)
            self._standing = now
            self.acceleration = np.zeros_like(self.acceleration)
        if self._wait:
            self._wait -= 1
        elif last is not None and expected is not None:
            beside = (v - last) / self._tick - expected
            self.acceleration = self.acceleration + self._tick / MEMORY * beside
