"""The controls of the atlas, and a map as plain numbers and colours for static/atlas.js."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import viser

from app.motion import colours
from app.panel.acts import Act, Put
from app.panel.fields import Field, Fields
from app.panel.html import note
from llsrbm.arrays import Array
from llsrbm.atlas.colours import COLOURS, SCALE, of_stop
from llsrbm.atlas.jumps import Axis, words_of
from llsrbm.atlas.map import ALL, NEAREST, Map, Scale
from llsrbm.number_text import short

_COLOURS = {colour.title: colour.name for colour in COLOURS.values()}
_PROJECTIONS = {"as in the design": NEAREST, "all of them": ALL}
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


class _Menus(NamedTuple):
    """A choice, and the axes to choose from."""

    choice: AtlasChoice
    varied: tuple[Axis, ...]  # by the sweep; none: there is no map

    @property
    def axes(self) -> tuple[Axis, Axis] | None:
        return self.choice.axes(self.varied)

    def heading(self, index: int) -> str:
        return _NONE if self.axes is None else self.axes[index].heading

    def with_axis(self, index: int, heading: str) -> _Menus:
        """With another axis; choosing the other one swaps them."""
        assert self.axes is not None
        names = [axis.name for axis in self.axes]
        chosen = next(axis.name for axis in self.varied if axis.heading == heading)
        if chosen == names[1 - index]:
            names.reverse()
        names[index] = chosen
        return self.having(x=names[0], y=names[1])

    def having(self, **changes: Any) -> _Menus:
        return self._replace(choice=replace(self.choice, **changes))


def _axis_menu(index: int, hint: str) -> Field[_Menus]:
    return Field(
        "xy"[index],
        hint,
        get=lambda menus: menus.heading(index),
        put=lambda menus, heading: menus.with_axis(index, heading),
        options=lambda menus, _: [axis.heading for axis in menus.varied],
        there=lambda menus: menus.axes is not None,
        stays=True,
    )


def _menus(sweeps: Sequence[str]) -> tuple[Field[_Menus], ...]:
    projections = {value: title for title, value in _PROJECTIONS.items()}
    return (
        Field(
            "Sweep",
            "Jumps that were planned before: those of a sweep, or those that plans begin from",
            get=lambda menus: menus.choice.sweep or sweeps[0],
            put=lambda menus, name: menus.having(sweep=name),
            options=tuple(sweeps),
        ),
        _axis_menu(0, "Horizontal axis"),
        _axis_menu(1, "Vertical axis"),
        Field(
            "Colour",
            "Figure of each jump by which its place in the map is coloured",
            get=lambda menus: COLOURS[menus.choice.colour].title,
            put=lambda menus, title: menus.having(colour=_COLOURS[title]),
            options=tuple(_COLOURS),
        ),
        Field(
            "Other axes",
            "Show the slice nearest to the design, or all jumps together",
            get=lambda menus: projections[menus.choice.projection],
            put=lambda menus, title: menus.having(projection=_PROJECTIONS[title]),
            options=tuple(_PROJECTIONS),
            there=lambda menus: len(menus.varied) > 2,
        ),
    )


class AtlasControls:
    """Dropdowns and the place of the map, in the container that is open."""

    def __init__(self, gui: viser.GuiApi, sweeps: Sequence[str], acted: Put) -> None:
        self._map = gui.add_html(_MAP)
        self._note = gui.add_html("")
        self._menus = _Menus(AtlasChoice(), ())
        self._fields = Fields(gui, self._menus, None, acted, Act.ATLAS)
        self._fields.add(*_menus(sweeps))

    @property
    def hints(self) -> dict[str, tuple[str, str]]:
        """As `Fields.hints`."""
        return self._fields.hints

    def read(self, choice: AtlasChoice) -> AtlasChoice:
        """The map with what was moved; what is no option stays as it is chosen."""
        menus, _ = self._fields.read(self._menus._replace(choice=choice), None)
        return menus.choice

    def show(self, choice: AtlasChoice, varied: Sequence[Axis], remark: str) -> None:
        """Put the controls where a choice has them; without `varied` axes there is no map."""
        self._menus = _Menus(choice, tuple(varied))
        self._fields.show(self._menus, None)
        self._note.content = note(remark) if remark else ""


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
