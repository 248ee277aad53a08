"""How high a CoM flies: it falls freely between the heights of a flight's ends."""

from collections.abc import Mapping
from math import sqrt
from typing import NamedTuple

from llsrbm.mechanics import GRAVITY

FREE_APEX = (0.0, 5.0)  # m, lowest and highest apex of plans that may fly as high as they like
APEX_LIMITS = ("apex_min", "apex_max")


class Flight(NamedTuple):
    """Heights of the CoM at lift-off and touchdown, m, and the time between them, s."""

    before: float
    after: float
    time: float

    @property
    def rising(self) -> float:
        """How long (s) it rises: all the time, or not at all, where it ends or begins highest."""
        speed = (self.after - self.before) / self.time + GRAVITY * self.time / 2  # m/s at lift-off
        return min(max(speed / GRAVITY, 0.0), self.time)

    @property
    def apex(self) -> float:
        """Largest height, m."""
        if self.rising == self.time:
            return self.after
        return self.before + GRAVITY * self.rising**2 / 2

    def time_to(self, apex: float) -> float:
        """How long (s) a flight between the same heights takes that rises to another one, m."""
        ends = self.before, self.after
        return sum(sqrt(2 * max(apex - end, 0.0) / GRAVITY) for end in ends)


def limits_apex(limits: Mapping[str, float] | None) -> bool:
    """Whether limits of a request say how high it flies."""
    return any(name in (limits or {}) for name in APEX_LIMITS)
