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
    """A request, and the number of the landing that is shown, from 0."""

    jump: Jump
    number: int

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
    _number(
        "Route forward [m]", "How far ahead of where the robot stood before", "forward", 0.01, 1, _M
    ),
    _number(
        "Route lateral [m]", "How far to the left of where it stood before", "lateral", 0.01, 1, _M
    ),
    _number(
        "Route height [m]", "How much higher than where it stood before", "height", 0.01, 1, _M
    ),
    _number("Route turn [deg]", "Turn on the way there, to the left", "twist", 1, _DEG, _TURN),
    _number(
        "Route slope [deg]", "Angle by which that surface rises ahead", "slope", 1, _DEG, _STEEP
    ),
    _number(
        "Route cross slope [deg]",
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
        self._gui, self._acted = gui, acted
        self._chosen = ChosenLanding(jump, 0)
        self._fields = Fields(gui, self._chosen, None, acted, Act.JUMP)

    def add(self) -> Buttons:
        """Add them to the container that is open."""
        self._list = self._gui.add_html(html.note(_NONE))
        self._fields.add(LANDING, *NUMBERS)
        return add_buttons(self._gui, "route", self._acted)

    @property
    def hints(self) -> dict[str, tuple[str, str]]:
        """As `Fields.hints`."""
        return self._fields.hints

    @property
    def chosen(self) -> int:
        """Number of the landing whose numbers are shown, from 0."""
        return self._chosen.number

    def read(self, jump: Jump) -> tuple[Jump, list[str]]:
        """The request with what was moved, and what had to be corrected."""
        self._chosen, complaints = self._fields.read(self._of(jump), None)
        return self._chosen.jump, complaints

    def show(self, jump: Jump) -> None:
        """Put them where a request has them; of a route with other landings, at the last."""
        if jump == self._chosen.jump and self._list.content:
            return
        others = len(jump.route) != len(self._chosen.jump.route)
        self._chosen = ChosenLanding(jump, len(jump.route) - 1) if others else self._of(jump)
        self._fields.show(self._chosen, None)
        self._list.content = landings_list(jump)

    def _of(self, jump: Jump) -> ChosenLanding:
        return ChosenLanding(jump, max(0, min(self._chosen.number, len(jump.route) - 1)))


def landings_list(jump: Jump) -> str:
    """A route's landings in words, as a list (HTML)."""
    if not jump.route:
        return html.note(_NONE)
    rows = "".join(f"<li>{escape(landing_words(each))}</li>" for each in jump.route)
    style = f"{html.SMALL};margin:0;padding-left:2.4em"
    return f'<ol aria-label="Landings" style="{style}">{rows}</ol>'
