"""`Channel`: messages take their time, and some never arrive."""

from collections import deque
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from llsrbm.errors import InputError

T = TypeVar("T")


@dataclass(frozen=True)
class Faults:
    """Shares of messages, 0 to 1, that are lost, or come `late_by`, s, later than the others.

    Raises `InputError`: a share or a time out of range.
    """

    lost: float = 0.0
    late: float = 0.0
    late_by: float = 0.02  # ten messages at 500 Hz: one pause of a busy computer or a radio link

    def __post_init__(self) -> None:
        for name in ("lost", "late"):
            share = getattr(self, name)
            if not 0 <= share <= 1:
                raise InputError(f"{name}: expected a share of 0 to 1, got {share:g}")
        if not 0 <= self.late_by <= 10:
            raise InputError(f"late_by: expected 0 to 10 s, got {self.late_by:g}")


class Channel(Generic[T]):
    """Carries messages in one direction, in the order in which they were sent.

    Each takes `delay`, s, at least 0, more or less by up to `spread`, and what `faults` say. One
    that is late holds up those behind it, as networks do that keep the order.
    """

    def __init__(
        self, delay: float, spread: float, faults: Faults, rng: np.random.Generator
    ) -> None:
        self._delay, self._spread, self._faults, self._rng = delay, spread, faults, rng
        self._under_way: deque[tuple[float, T]] = deque()

    def send(self, time: float, message: T) -> None:
        """Hand over a message at a time, s."""
        # All are drawn whatever the shares, so that runs of one seed differ in these alone.
        drawn, lost, late = self._rng.random(3)
        if lost < self._faults.lost:
            return
        arrival = time + max(0.0, self._delay + self._spread * (2 * drawn - 1))
        if late < self._faults.late:
            arrival += self._faults.late_by
        if self._under_way:
            arrival = max(arrival, self._under_way[-1][0])
        self._under_way.append((arrival, message))

    def arrived(self, time: float) -> list[T]:
        """The messages that have arrived by a time, s, and were not taken yet."""
        messages = []
        while self._under_way and self._under_way[0][0] <= time:
            messages.append(self._under_way.popleft()[1])
        return messages
