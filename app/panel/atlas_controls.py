"""The controls of the atlas: which sweep, which axes, which colour; the map itself is above them.

The map is drawn by the page's script (static/atlas.js) from what the session sends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import viser

from app.guard.validation import option, put
from app.panel.acts import Act, Put, callback
from app.panel.html import note
from llsrbm.atlas.colours import COLOURS
from llsrbm.atlas.jumps import Axis
from llsrbm.atlas.map import ALL, NEAREST

_COLOURS = {colour.title: colour.name for colour in COLOURS.values()}
_PROJECTIONS = {"as in the design": NEAREST, "all of the sweep": ALL}
_NONE = "none"
_MAP = '<div class="llsrbm-atlas"></div>'  # by which atlas.js finds its place


@dataclass(frozen=True)
class AtlasChoice:
    """A map."""

    seen: bool = False  # whether the page has shown the atlas: before that nothing is read or drawn
    sweep: str = ""  # its name; "": the first that there is
    # x, y: names of axes; where a sweep does not vary one, another stands in for it
    x: str = "twist"
    y: str = "forward"
    colour: str = "plannable"  # name of one of `llsrbm.atlas.colours.COLOURS`
    projection: str = NEAREST  # one of `llsrbm.atlas.map.PROJECTIONS`

    def axes(self, varied: tuple[Axis, ...]) -> tuple[Axis, Axis] | None:
        """The chosen ones of what a sweep varies, two different ones; None: it varies only one."""
        if len(varied) < 2:
            return None
        named = {axis.name: axis for axis in varied}
        x = named.get(self.x) or next(axis for axis in varied if axis.name != self.y)
        y = named.get(self.y) if self.y != x.name else None
        return x, y or next(axis for axis in varied if axis is not x)


class AtlasControls:
    """Dropdowns and the place of the map, in the container that is open."""

    def __init__(self, gui: viser.GuiApi, sweeps: Sequence[str], acted: Put) -> None:
        self._sweeps = tuple(sweeps)
        self._axes: dict[str, str] = {}  # title -> name
        self._map = gui.add_html(_MAP)
        self._note = gui.add_html("")
        self._sweep = gui.add_dropdown(
            "Sweep", self._sweeps, hint="Jumps that have been planned and simulated before"
        )
        self._x = gui.add_dropdown("x", (_NONE,), hint="Axis to the right")
        self._y = gui.add_dropdown("y", (_NONE,), hint="Axis upwards")
        self._colour = gui.add_dropdown("Colour", tuple(_COLOURS))
        self._projection = gui.add_dropdown(
            "Other axes",
            tuple(_PROJECTIONS),
            hint="The slice nearest to the present design, or all jumps of the sweep together",
        )
        menus: tuple[Any, ...] = (self._sweep, self._x, self._y, self._colour, self._projection)
        for menu in menus:
            menu.on_update(callback(acted, Act.ATLAS))

    def read(self, choice: AtlasChoice) -> AtlasChoice:
        """The map as the controls stand; what is no option stays as it is chosen."""
        ignored: list[str] = []
        sweep = option("Sweep", self._sweep.value, self._sweeps, "", ignored)
        colour = option("Colour", self._colour.value, tuple(_COLOURS), "", ignored)
        projection = option("Other axes", self._projection.value, tuple(_PROJECTIONS), "", ignored)
        x, y = (self._axes.get(str(handle.value), "") for handle in (self._x, self._y))
        return self._with_axes(
            replace(
                choice,
                sweep=sweep or choice.sweep,
                colour=_COLOURS.get(colour, choice.colour),
                projection=_PROJECTIONS.get(projection, choice.projection),
            ),
            x,
            y,
        )

    def show(self, choice: AtlasChoice, varied: Sequence[Axis], remark: str) -> None:
        """Put the controls where a choice has them; without `varied` axes there is no map."""
        put(self._sweep, choice.sweep or self._sweeps[0])
        put(self._colour, COLOURS[choice.colour].title)
        names = {value: title for title, value in _PROJECTIONS.items()}
        put(self._projection, names[choice.projection])
        self._axes = {axis.heading: axis.name for axis in varied}
        chosen = choice.axes(tuple(varied))
        for index, handle in enumerate((self._x, self._y)):
            titles = tuple(self._axes) or (_NONE,)
            if tuple(handle.options) != titles:
                handle.options = titles
            put(handle, chosen[index].heading if chosen else _NONE)
        self._projection.visible = len(varied) > 2
        self._note.content = note(remark) if remark else ""

    def _with_axes(self, choice: AtlasChoice, x: str, y: str) -> AtlasChoice:
        """With these axes; choosing the other axis' one swaps them."""
        before = choice.axes(tuple(_named(self._axes)))
        if before is None or not x or not y:
            return choice
        if x == y:
            x, y = (x, before[0].name) if y == before[1].name else (before[1].name, y)
        if (x, y) == (before[0].name, before[1].name):
            return choice  # also where others stand in for what the choice names
        return replace(choice, x=x, y=y)


def _named(axes: dict[str, str]) -> list[Axis]:
    return [Axis(name, title) for title, name in axes.items()]
