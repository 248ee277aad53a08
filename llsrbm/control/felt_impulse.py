"""Touchdown or push: whether the legs felt what the centroidal motion shows.

In flight a detector sees that something has given the robot an impulse. Feet that meet the ground
pass theirs through the legs; a push on the trunk does not. Over the last `WINDOW`

    J = m (dv + g t)          what the CoM shows,
    J_feet = sum f dt         what the legs felt (`FootForces`),

and it was the ground if enough of J went through the feet: J_feet . J >= SHARE |J|^2. After a push
the detector goes on reporting it for a while, when J is over and both are noise; until the flight
ends, only an impulse that stands out of noise counts.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from llsrbm.mechanics import GRAVITY

Array = NDArray[np.float64]

WINDOW = 0.02  # s, the detector's own longest window
# Of ground contacts it is about 1 by the time they are detected, of pushes below 0.1.
SHARE = 0.3
# m/s of the CoM that feet must have caused after a push: three times what noise makes of the sum.
AFTER_PUSH = 0.03


class FeltImpulse:
    """Both impulses of one flight.

    Attributes:
        pushed: whether something was hit in this flight that was not the ground.
    """

    def __init__(self, mass: float, tick: float) -> None:
        """Args: mass: kg, of the robot; tick: s between updates."""
        self._mass, self._tick = mass, tick
        self._recent: deque[tuple[Array, Array]] = deque(maxlen=max(2, round(WINDOW / tick) + 1))
        self.pushed = False

    def reset(self) -> None:
        """Begin a flight."""
        self._recent.clear()
        self.pushed = False

    def update(self, com_velocity: Array, feet: Array) -> None:
        """Take a tick's end: (3,) m/s of the CoM, and (3,) N, what feet felt during the tick."""
        self._recent.append((np.array(com_velocity), feet))

    def is_ground(self) -> bool:
        """Whether what the detector reports came from the ground; it is remembered if not."""
        if len(self._recent) < 2:
            return True
        ticks = len(self._recent) - 1
        shown = self._recent[-1][0] - self._recent[0][0]
        shown[2] += GRAVITY * ticks * self._tick
        shown *= self._mass
        felt = sum((f for _, f in list(self._recent)[1:]), np.zeros(3)) * self._tick
        enough = float(felt @ shown) >= SHARE * float(shown @ shown)
        if self.pushed:
            enough = enough and float(np.linalg.norm(felt)) >= AFTER_PUSH * self._mass
        self.pushed = self.pushed or not enough
        return enough
