"""Accelerations that come beside those that commands were made for, while feet stand.

Rotors that are heavier than a file says, friction that is more or less, stiction: they move joints
and base, tick after tick, to the same side. The difference between measured accelerations and those
that were expected of the commands that acted,

    d += (dv/dt - a_expected) dt / `MEMORY`,    a_expected = a of the program + d,

is what the next program leaves out of what it asks for: the integral part of the tasks' feedback.
Unlike integrated errors d does not grow while drives or friction cannot give what is wanted. Feet
that stand are held by the ground and leave out nothing. In flight drives are near their limits, and
d made feet miss their places by as much again: there is none.
"""

import numpy as np

from llsrbm.arrays import Array, BoolArray

MEMORY = 0.03  # s; in less, noise of measured velocities comes through
SETTLING = 0.05  # s after feet have landed or left, in which impacts decide


class Unmodelled:
    """`acceleration`: d (n,), m/s2 and rad/s2; `tick`: of the controller, s."""

    def __init__(self, tick: float, velocities: int) -> None:
        self._tick = tick
        self._last: Array | None = None  # (n,) measured velocities
        self._standing: bytes | None = None
        self._settling = 0  # ticks
        self.acceleration = np.zeros(velocities)

    def measured(self, v: Array, expected: Array | None, standing: BoolArray) -> None:
        """Take velocities (n,), measured as a tick ends; accelerations (n,) that were expected in
        it, None: unknown; and which feet (L,) stand.
        """
        last, self._last = self._last, v
        if standing.tobytes() != self._standing:
            if self._standing is not None:
                self._settling = round(SETTLING / self._tick)
            self._standing = standing.tobytes()
            self.acceleration = np.zeros_like(v)
        if self._settling:
            self._settling -= 1
        elif standing.any() and last is not None and expected is not None:
            beside = (v - last) / self._tick - expected
            self.acceleration = self.acceleration + self._tick / MEMORY * beside
