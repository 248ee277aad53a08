"""Controls of single feet's landing places, by numbers; in the picture they are dragged."""

from __future__ import annotations

from typing import NamedTuple

import viser

from app.panel.acts import Act, Buttons, Put, add_buttons
from app.panel.fields import Field, Fields
from llsrbm.planning.problem.stones import within_reach
from llsrbm.request.jump import Jump
from llsrbm.request.stones import Stone
from llsrbm.robots import Robot

_AHEAD, _LEFT, _UP = range(3)
_MM = 1000.0
_FARTHEST, _HIGHEST = 300.0, 150.0  # mm, beyond all legs here


class Chosen(NamedTuple):
    """A request, and the leg whose foot's landing place is shown; "": of no robot yet."""

    jump: Jump
    leg: str
    robot: Robot | None

    @property
    def place(self) -> tuple[float, ...]:
        """(3,) m beside where the foot lands by itself."""
        found = (stone[1:] for stone in self.jump.stones if stone.leg == self.leg)
        return next(found, (0.0, 0.0, 0.0))

    def moved(self, axis: int, shown: float) -> Chosen:
        """The same with another number, as far as the leg reaches."""
        if self.robot is None or self.leg not in self.robot.leg_names:
            return self
        place = list(self.place)
        place[axis] = shown / _MM
        stone = Stone(self.leg, *place)
        return self._replace(jump=within_reach(self.jump, stone, self.robot))


def _number(label: str, hint: str, axis: int, ends: tuple[float, float]) -> Field[Chosen]:
    return Field(
        label,
        hint,
        get=lambda chosen: _MM * chosen.place[axis],
        put=lambda chosen, shown: chosen.moved(axis, shown),
        ends=ends,
        there=lambda chosen: bool(chosen.leg),
    )


LEG: Field[Chosen] = Field(
    "Foot",
    "Leg whose landing place the numbers below are of",
    get=lambda chosen: chosen.leg,
    put=lambda chosen, leg: chosen._replace(leg=leg),
    options=lambda _, legs: legs,
    there=lambda chosen: bool(chosen.leg),
)
NUMBERS = (
    _number(
        "Ahead [mm]",
        "Landing place of that foot, ahead of where it lands by itself, as the robot looks then",
        _AHEAD,
        (-_FARTHEST, _FARTHEST),
    ),
    _number(
        "Left [mm]",
        "Landing place of that foot, to the left of where it lands by itself",
        _LEFT,
        (-_FARTHEST, _FARTHEST),
    ),
    _number(
        "Up [mm]",
        "Height of a stone under that foot, above the surface that the other feet land on",
        _UP,
        (0.0, _HIGHEST),
    ),
)


class FootholdControls:
    """A menu of legs, three numbers, and a button that clears all of them."""

    def __init__(self, gui: viser.GuiApi, jump: Jump, acted: Put) -> None:
        self._gui, self._acted = gui, acted
        self._chosen = Chosen(jump, "", None)
        self._fields = Fields(gui, self._chosen, (), acted, Act.JUMP)

    def add(self) -> Buttons:
        """Add them to the container that is open."""
        self._fields.add(LEG, *NUMBERS)
        return add_buttons(self._gui, "footholds", self._acted)

    @property
    def hints(self) -> dict[str, tuple[str, str]]:
        """As `Fields.hints`."""
        return self._fields.hints

    def read(self, jump: Jump) -> tuple[Jump, list[str]]:
        """The request with what was moved, and what had to be corrected."""
        found, complaints = self._fields.read(self._chosen._replace(jump=jump), self._legs)
        self._chosen = found
        return found.jump, complaints

    def show(self, jump: Jump, robot: Robot | None) -> None:
        """Put them where a request has them, of a leg of its robot."""
        self._chosen = Chosen(jump, self._chosen.leg, robot)
        if self._chosen.leg not in self._legs:
            self._chosen = self._chosen._replace(leg=next(iter(self._legs), ""))
        self._fields.show(self._chosen, self._legs)

    @property
    def _legs(self) -> tuple[str, ...]:
        return () if self._chosen.robot is None else self._chosen.robot.leg_names
