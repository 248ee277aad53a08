"""A push: an impulse and a moment on the trunk, at one moment of a simulation."""

from __future__ import annotations

import math
from dataclasses import dataclass

from llsrbm.errors import InputError

DURATION = 0.02  # s that a push takes: a shove by hand is longer, a hit by a ball shorter
LARGEST_IMPULSE = 200.0  # N s; it throws the heaviest robot here, of 54 kg, aside with 4 m/s
LARGEST_MOMENT = 50.0  # N m s

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Push:
    """A constant wrench on the trunk's CoM over `DURATION`.

    Attributes:
        time: s since the plan's start, when it begins.
        impulse: N s, world frame: the integral of its force.
        moment: N m s, world frame: the integral of its moment about the trunk's CoM.

    Raises:
        InputError: numbers that are not finite or too large, or a time before the start.
    """

    time: float
    impulse: Vector
    moment: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name, values, highest, unit in (
            ("impulse", self.impulse, LARGEST_IMPULSE, "N s"),
            ("moment", self.moment, LARGEST_MOMENT, "N m s"),
        ):
            if len(values) != 3 or not all(map(math.isfinite, values)):
                raise InputError(f"push: {name}: expected three finite numbers, got {values}")
            if math.hypot(*values) > highest:
                raise InputError(
                    f"push: {name}: expected at most {highest:g} {unit}, "
                    f"got {math.hypot(*values):g} {unit}"
                )
        if not (math.isfinite(self.time) and self.time >= 0):
            raise InputError(f"push: time: expected at least 0 s, got {self.time}")
