"""A map as the page's script draws it (static/atlas.js): plain numbers and colours."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.motion import colours
from llsrbm.atlas.colours import COLOURS, SCALE, of_stop
from llsrbm.atlas.jumps import words_of
from llsrbm.atlas.map import NEAREST, Map, Scale
from llsrbm.mechanics import Array
from llsrbm.request.messages import short

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
            low, high = (short(float(f"{end:.3g}")) for end in (values.min(), values.max()))
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
