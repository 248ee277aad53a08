"""The controls of the atlas, and a map as plain numbers and colours for static/atlas.js."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import viser

from app.guard.validation import option, put
from app.motion import colours
from app.panel.acts import Act, Put, callback
from app.panel.html import note
from llsrbm.atlas.colours import COLOURS, SCALE, of_stop
from llsrbm.atlas.jumps import Axis, words_of
from llsrbm.atlas.map import ALL, NEAREST, Map, Scale
from llsrbm.mechanics import Array
from llsrbm.request.numbers import short

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


_DIGITS = 4  # of what is sent: more than the eye tells apart


def as_sent(drawn: Map, sweep: str) -> dict[str, Any]:
    """A map, cells row by row from the lowest one; the sweep's name comes back with a click."""
    jumps, colour = drawn.jumps, drawn.colour
    numbers = np.where(drawn.jump >= 0, jumps.numbers[drawn.jump], -1)
    figures = {
        name: _plain(drawn.of(each) * each.scale)
        for name, each in COLOURS.items()
        if not each.categorical and (name != "strict" or jumps.simulated)
    }
    painted = (drawn.colour_of(float(value)) for value in drawn.value.flat)
    return {
        "sweep": sweep,
        "x": _axis(drawn.x),
        "y": _axis(drawn.y),
        "jump": numbers.ravel().tolist(),
        "at": None if drawn.x.listed and drawn.y.listed else _places(drawn),
        "count": drawn.count.ravel().tolist() if drawn.projection != NEAREST else None,
        "fill": [None if each is None else colours.css(each) for each in painted],
        "figures": figures,
        "stop": _plain(drawn.of(COLOURS["stopped-by"])),
        "stops": [words_of(name) for name in jumps.stops],
        "slice": slice_of(drawn),
        "border": [_line(drawn, line) for line in drawn.border],
        "heading": colour.heading,
        "legend": _categories(drawn) if colour.categorical else _scale(drawn),
    }


def _places(drawn: Map) -> list[list[float | None]]:
    """Where in their cells the jumps of a drawn sweep are, along x and along y."""
    requested = drawn.jumps.requested
    return [_plain(requested[s.axis.name][drawn.jump] * s.axis.scale) for s in (drawn.x, drawn.y)]


def slice_of(drawn: Map) -> str:
    """The values of the axes that are not shown, in words; "" if there are none."""
    shown = {drawn.x.axis.name, drawn.y.axis.name}
    parts = []
    for axis in drawn.jumps.axes:
        if axis.name not in shown:
            values = drawn.jumps.requested[axis.name][drawn.members] * axis.scale
            low, high = (short(end, 3) for end in (values.min(), values.max()))
            span = low if low == high else f"{low} to {high}"
            parts.append(f"{axis.title} {span} {axis.unit}".rstrip())
    line = ", ".join(parts)
    return f"Slice: {line}" if parts and drawn.projection == NEAREST else line


def _axis(scale: Scale) -> dict[str, Any]:
    axis = scale.axis
    return {
        "title": axis.title,
        "unit": axis.unit,
        "edges": _plain(scale.edges * axis.scale),
        "centres": _plain(scale.centres * axis.scale),
    }


def _line(drawn: Map, line: Array) -> list[list[float | None]]:
    scales = np.array([drawn.x.axis.scale, drawn.y.axis.scale])
    return [_plain(point) for point in line * scales]


def _scale(drawn: Map) -> dict[str, Any]:
    low, high = (end * drawn.colour.scale for end in drawn.ends)
    return {"low": f"{low:.3g}", "high": f"{high:.3g}", "stops": [colours.css(c) for c in SCALE]}


def _categories(drawn: Map) -> dict[str, Any]:
    stops = drawn.jumps.stops
    return {"keys": [[colours.css(of_stop(k, stops)), words_of(stops[k])] for k in drawn.stops]}


def _plain(values: Array) -> list[float | None]:
    """For JSON, which knows no NaN."""
    return [float(f"{value:.{_DIGITS}g}") if np.isfinite(value) else None for value in values.flat]
