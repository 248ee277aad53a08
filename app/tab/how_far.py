"""How far a robot jumps in one direction: the search for it, as a value, as far as it has come."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from llsrbm.largest_jump import DIRECTIONS, Direction, Largest
from llsrbm.request.design import Design
from llsrbm.request.jump import Jump
from llsrbm.request.tuning import Tuning

_TITLES = {
    "twist": "Twist to the left",
    "twist-right": "Twist to the right",
    "forward": "Forward",
    "backward": "Backward",
    "lateral": "To the left",
    "lateral-right": "To the right",
    "up": "Up",
    "down": "Down",
}
CHANGED = "not searched to the end, as the request has changed"


@dataclass(frozen=True, eq=False)
class HowFar:
    """The largest jump in a direction, all else as a request has it: searched for, or found."""

    towards: str  # a name of `DIRECTIONS`
    jump: Jump  # jump, tuning: what was asked for
    tuning: Tuning
    ticket: int = 0  # of the job that looks for it; 0: it has ended
    note: str = ""  # on that job's progress; "": it has not begun
    found: Largest | None = None
    why_not: str = ""  # there is none, and why

    @property
    def direction(self) -> Direction:
        """Which component grows, and to which side."""
        return DIRECTIONS[self.towards]

    @property
    def running(self) -> bool:
        """Whether it is still being looked for."""
        return self.ticket != 0

    def is_of(self, design: Design) -> bool:
        """Whether a design asks for just what it was begun with."""
        return (design.jump, design.tuning) == (self.jump, self.tuning)

    def answers(self, design: Design) -> bool:
        """Whether it holds for a design, however much that asks for of the component itself."""
        without: dict[str, Any] = {self.direction.field: 0.0}
        same = replace(design.jump, **without) == replace(self.jump, **without)
        return same and design.tuning == self.tuning

    def sentence(self, design: Design) -> str:
        """The result, or how far the search has come, for a visitor with such a design."""
        title = _TITLES[self.towards]
        if self.running:
            return f"{title}: {self.note or 'waiting for a computing process'} ..."
        if self.found is None:
            return f"{title}: {self.why_not}."
        value = self.direction.in_words(self.found.value)
        line = f"{title}: {value} is the largest found; what stops it: {self.found.limit}."
        return line if self.answers(design) else f"Of the request before. {line}"


def direction_of(component: str, value: float) -> str:
    """The name of the direction in which a request of that much of a component is more of it."""
    sign = -1 if value < 0 else 1
    pairs = DIRECTIONS.items()
    return next(name for name, each in pairs if (each.field, each.sign) == (component, sign))
