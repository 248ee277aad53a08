"""Controls of a route's landings, by numbers; in the picture they are clicked and dragged."""

from __future__ import annotations

import math
from html import escape
from typing import NamedTuple

import viser

from app.panel import html
from app.panel.acts import Act, Buttons, Put, add_buttons
from app.panel.fields import Ends, Field, Fields
from llsrbm.look.titles import landing_words
from llsrbm.request.jump import Jump
from llsrbm.request.route import FURTHEST, STEEPEST

_DEG = 180 / math.pi
_NONE = "No route yet: click its landings on the ground, or add one after this jump's."


class ChosenLanding(NamedTuple):
    """A request, and the number of the landing that is shown, from 0; of no route it is 0."""

    jump: Jump
    number: int

    @classmethod
    def of(cls, jump: Jump, number: int) -> ChosenLanding:
        """The landing of that number, or the last one."""
        return cls(jump, max(0, min(number, len(jump.route) - 1)))

    def amount(self, name: str) -> float:
        """One of its numbers, SI."""
        found: float = getattr(self.jump.landings[self.number], name)
        return found

    def but(self, name: str, value: float) -> ChosenLanding:
        """The same with another number, SI."""
        route = list(self.jump.route)
        route[self.number] = route[self.number]._replace(**{name: value})
        return self._replace(jump=self.jump.along(route))


def _number(
    label: str, hint: str, name: str, step: float, scale: float, ends: Ends
) -> Field[ChosenLanding]:
    """A number of the landing that is chosen; `step`, `ends`: in display units, `scale` to one."""
    return Field(
        label,
        hint,
        get=lambda chosen: scale * chosen.amount(name),
        put=lambda chosen, shown: chosen.but(name, shown / scale),
        ends=ends,
        step=step,
        there=lambda chosen: bool(chosen.jump.route),
    )


LANDING: Field[ChosenLanding] = Field(
    "Landing",
    "Landing of the route that the numbers below are of",
    get=lambda chosen: str(chosen.number + 1),
    put=lambda chosen, shown: chosen._replace(number=int(shown) - 1),
    options=lambda chosen, _: [str(k + 1) for k in range(len(chosen.jump.route))],
    there=lambda chosen: bool(chosen.jump.route),
)
_M, _TURN, _STEEP = (
    (-FURTHEST["forward"], FURTHEST["forward"]),
    (-round(_DEG * FURTHEST["twist"]), round(_DEG * FURTHEST["twist"])),
    (-round(_DEG * STEEPEST), round(_DEG * STEEPEST)),
)
NUMBERS: tuple[Field[ChosenLanding], ...] = (
    _number("Ahead [m]", "How far ahead of where the robot stood before", "forward", 0.01, 1, _M),
    _number("Left [m]", "How far to the left of where it stood before", "lateral", 0.01, 1, _M),
    _number("Up [m]", "How much higher than where it stood before", "height", 0.01, 1, _M),
    _number("Turn [deg]", "Turn on the way there, to the left", "twist", 1, _DEG, _TURN),
    _number("Slope [deg]", "Angle by which that surface rises ahead", "slope", 1, _DEG, _STEEP),
    _number(
        "Cross [deg]",
        "Angle by which that surface rises to the left",
        "cross_slope",
        1,
        _DEG,
        _STEEP,
    ),
)


class RouteControls:
    """The list of landings, a menu of them with its numbers, and buttons."""

    def __init__(self, gui: viser.GuiApi, jump: Jump, acted: Put) -> None:
        """Add them to the container that is open."""
        self._list = gui.add_html(landings_list(jump))
        self.fields = Fields(gui, ChosenLanding(jump, 0), None, acted, Act.ROUTE)
        self.fields.add(LANDING, *NUMBERS)
        self.buttons: Buttons = add_buttons(gui, "route", acted)
        self._jump = jump

    def show(self, chosen: ChosenLanding) -> None:
        """Put them where a request has them."""
        self.fields.show(chosen, None)
        if chosen.jump != self._jump:
            self._jump = chosen.jump
            self._list.content = landings_list(chosen.jump)


def landings_list(jump: Jump) -> str:
    """A route's landings in words, as a list (HTML)."""
    if not jump.route:
        return html.note(_NONE)
    rows = "".join(f"<li>{escape(landing_words(each))}</li>" for each in jump.route)
    style = f"{html.SMALL};margin:0;padding-left:2.4em"
    return f'<ol aria-label="Landings" style="{style}">{rows}</ol>'
