"""Routes: landings one after the other, each said from where the robot stood before.

A route's file is TOML, angles in degrees:

    [[landing]]
    forward = 0.4
    height = 0.1
    twist = 30
    slope = 10
"""

import math
import reprlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from llsrbm.errors import InputError
from llsrbm.request.messages import FieldSpec, Number, choices
from llsrbm.request.tables import read_table

MOST = 5  # landings; of more the solver is too large to build in a minute
FURTHEST = {"twist": 4 * math.pi, "forward": 3.0, "lateral": 3.0, "height": 3.0}
"""Most of each component (rad, m), to either side, that may be asked for, so that a slip of units
keeps no solver busy: nearly twice the most that a robot here was found to do (docs/figures.md).
"""
STEEPEST = math.radians(30)  # rad of a surface: beyond it feet slip on most grounds
SLOPES = ("slope", "cross_slope")
_TURNS = ("twist", *SLOPES)  # angles: degrees in a route's file
_FILE = "a route (TOML, a table [[landing]] for each)"


class Landing(NamedTuple):
    """Where one jump of a route leads, in axes of the robot that takes off: rad and m."""

    forward: float = 0.0
    lateral: float = 0.0
    height: float = 0.0
    twist: float = 0.0
    # By which the surface rises ahead, and to the left, as the robot looks that lands there.
    slope: float = 0.0
    cross_slope: float = 0.0


class Waypoint(NamedTuple):
    """Where a robot stands on its route, in axes of the start: m, and rad about the vertical."""

    x: float
    y: float
    z: float
    heading: float


START = Waypoint(0.0, 0.0, 0.0, 0.0)


def waypoints(route: Iterable[Landing]) -> tuple[Waypoint, ...]:
    """Where the robot stands after each landing of a route."""
    found, here = [], START
    for landing in route:
        c, s = math.cos(here.heading), math.sin(here.heading)
        here = Waypoint(
            here.x + c * landing.forward - s * landing.lateral,
            here.y + s * landing.forward + c * landing.lateral,
            here.z + landing.height,
            here.heading + landing.twist,
        )
        found.append(here)
    return tuple(found)


def through(places: Sequence[Waypoint], route: Sequence[Landing] = ()) -> tuple[Landing, ...]:
    """The route whose landings stand at these places; with the slopes of another one's landings."""
    found = []
    for number, (before, there) in enumerate(pairwise((START, *places))):
        c, s = math.cos(before.heading), math.sin(before.heading)
        x, y = there.x - before.x, there.y - before.y
        like = route[number] if number < len(route) else Landing()
        found.append(
            like._replace(
                forward=c * x + s * y,
                lateral=c * y - s * x,
                height=there.z - before.z,
                twist=there.heading - before.heading,
            )
        )
    return tuple(found)


@dataclass(frozen=True)
class Route(FieldSpec):
    """Any number of `Landing`s, or tables of their fields as files have them."""

    def checked(self, name: str, value: Any) -> tuple[Landing, ...]:
        """See `FieldSpec`; whether the robot reaches them is checked when it plans."""
        if isinstance(value, str | bytes | Mapping) or not isinstance(value, Iterable):
            raise _refused(name, value)
        rows = list(value)
        if len(rows) > MOST:
            raise InputError(f"{name}: expected at most {MOST} landings, got {len(rows)}")
        return tuple(_landing(f"{name}: landing {k + 1}", row) for k, row in enumerate(rows))


def as_rows(route: Iterable[Landing]) -> list[dict[str, float]]:
    """Landings as files have them."""
    return [landing._asdict() for landing in route]


def load_route(path: str | Path) -> tuple[Landing, ...]:
    """The route in a TOML file. Raises `InputError`: it cannot be read, or is none; one line."""
    table = read_table(Path(path), _FILE)
    rows = table.get("landing")
    if list(table) != ["landing"] or not isinstance(rows, tuple):
        raise InputError(f"{path}: expected {_FILE}, got {reprlib.repr(list(table))}")
    if not rows:
        raise InputError(f"{path}: no landing; expected {_FILE}")
    in_rad = [
        {n: math.radians(v) if n in _TURNS and _is_number(v) else v for n, v in row.items()}
        if isinstance(row, Mapping)
        else row
        for row in rows
    ]
    try:
        return Route("").checked("route", in_rad)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _landing(name: str, row: Any) -> Landing:
    if isinstance(row, Landing):
        row = row._asdict()
    if not isinstance(row, Mapping):
        raise _refused(name, row)
    for field in row:
        if field not in Landing._fields:
            raise InputError(
                f"{name}: unknown {reprlib.repr(field)}; {choices(str(field), Landing._fields)}"
            )
    return Landing(**{field: _amount(name, field, value) for field, value in row.items()})


def _amount(name: str, field: str, value: Any) -> float:
    most = FURTHEST.get(field, STEEPEST)
    unit = "rad" if field in _TURNS else "m"
    return Number("", "", -most, most, unit).checked(f"{name}: {field}", value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _refused(name: str, value: Any) -> InputError:
    fields = ", ".join(Landing._fields)
    return InputError(f"{name}: expected landings, each of {fields}, got {reprlib.repr(value)}")
