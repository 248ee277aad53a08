"""The request: robot, planning model, and where and how to jump."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from typing import Annotated, Any

from llsrbm.errors import InputError
from llsrbm.number_text import short
from llsrbm.request.messages import (
    FieldSpec,
    Name,
    Number,
    Whole,
    check_fields,
    choices,
    field_specs,
)
from llsrbm.request.obstacle import HIGHEST, WIDEST
from llsrbm.request.route import MOST, SLOPES, STEEPEST, Landing, Route, as_rows
from llsrbm.request.stones import STONE, Stone, StoneList, by_leg

AMOUNTS = ("twist", "forward", "lateral", "height", "roll", "pitch", "speed", "end_speed")
"""Fields of a `Jump` that are numbers."""

COMPONENTS = ("twist", "forward", "lateral", "height")
"""Fields of a `Jump` that say where it leads."""

INCLINES = (*SLOPES, "takeoff_slope", "takeoff_cross_slope")
"""Fields of a `Jump` that say how the surfaces slope under it."""

STEPS = {"twist": math.radians(1.0), "forward": 0.01, "lateral": 0.01, "height": 0.01}
"""Whole steps (rad, m) of which the components of nearest jumps are."""

TYPE_PARAMETERS = ("roll", "pitch", "speed", "end_speed", "hops", "gap", "bar")
"""Fields of a `Jump` beyond where to land, which a jump type may ask for."""

PLAIN, IN_A_ROW = "together", "hops"
"""Jump types: the default one, and that of routes of several landings that name no other."""

FREE, HELD = "free", "held"
ARMS = (FREE, HELD)

PAYLOAD = "KG[,X,Y,Z]"
FARTHEST = 1.0  # m, of a payload from the origin of the trunk's frame
_STATED_ALONE = ("stones", "route")
_WHOLE = 1e-3  # of a turn: as near as degrees on a command line are


@dataclass(frozen=True)
class Load(FieldSpec):
    """A mass on the trunk and where it is: none, or kg and x, y, z in m; alone at the origin."""

    def checked(self, name: str, value: Any) -> tuple[float, ...]:
        """See `FieldSpec`; four numbers, or none."""
        numbers: list[float] | None = None
        with suppress(TypeError, InputError):
            numbers = [Number("").checked(name, each) for each in value]
        if isinstance(value, str | Mapping) or numbers is None or len(numbers) not in (0, 1, 4):
            raise InputError(f"{name}: expected {PAYLOAD} in kg and m, got {reprlib.repr(value)}")
        if not numbers or numbers[0] == 0:
            return ()
        mass, *place = (*numbers, 0.0, 0.0, 0.0)[:4]
        if mass < 0 or max(map(abs, place)) > FARTHEST:
            raise InputError(
                f"{name}: expected no negative mass, at most {FARTHEST:g} m from the origin of the "
                f"trunk's frame, got {reprlib.repr(value)}"
            )
        return (mass, *place)


def parse_payload(text: str) -> tuple[float, ...]:
    """The payload that a line of text means: "3" or "3,0.1,0,0.05". Raises `InputError`: none."""
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise InputError(
            f"payload: expected {PAYLOAD} in kg and m, got {reprlib.repr(text)}"
        ) from None


@dataclass(frozen=True)
class Jump:
    """One jump, from the robot's default posture to the same posture elsewhere; angles in rad.

    World = heading at the start. Each field states its meaning and unit with its type.
    """

    robot: Annotated[str, Name("A name (see `llsrbm robots`) or a robot file's path", "", 1000)] = (
        "anymal"
    )
    model: Annotated[str, Name("See `llsrbm models`")] = "llsrbm-plus"
    twist: Annotated[float, Number("Turn about the vertical, to the left", "DEG", unit="rad")] = 0.0
    forward: Annotated[float, Number("Displacement along x", "M", unit="m")] = 0.0
    lateral: Annotated[float, Number("Displacement to the left", "M", unit="m")] = 0.0
    height: Annotated[
        float, Number("Height of the landing surface above the ground at the start", "M", unit="m")
    ] = 0.0
    type: Annotated[
        str,
        Name(
            "Jump type: a name (see `llsrbm types`), the path of a type's TOML file, or an order "
            'of feet: "all - right - none - right - all"',
            "",
            1000,
        ),
    ] = PLAIN
    roll: Annotated[
        float,
        Number(
            "Whole turns about the body's x axis: 360 is a roll to the right", "DEG", unit="rad"
        ),
    ] = 0.0
    pitch: Annotated[
        float,
        Number(
            "Whole turns about the body's y axis: 360 is a front flip, -360 a back flip",
            "DEG",
            unit="rad",
        ),
    ] = 0.0
    speed: Annotated[float, Number("Forward speed of the CoM at the start", "M/S", unit="m/s")] = (
        0.0
    )
    end_speed: Annotated[
        float, Number("Forward speed at the end, along the landing heading", "M/S", unit="m/s")
    ] = 0.0
    hops: Annotated[
        int, Whole("Jumps in a row, each as far as the displacement says", "N", 1, MOST)
    ] = 1
    gap: Annotated[
        float,
        Number("Width of the gap that the whole robot passes over", "M", 0.0, WIDEST, "m"),
    ] = 0.0
    bar: Annotated[
        float,
        Number("Height of the bar that the whole robot passes over", "M", 0.0, HIGHEST, "m"),
    ] = 0.0
    slope: Annotated[
        float,
        Number(
            "Angle by which the landing surface rises ahead, as the robot looks that lands",
            "DEG",
            -STEEPEST,
            STEEPEST,
            "rad",
        ),
    ] = 0.0
    cross_slope: Annotated[
        float,
        Number(
            "Angle by which the landing surface rises to the left, as the robot looks that lands",
            "DEG",
            -STEEPEST,
            STEEPEST,
            "rad",
        ),
    ] = 0.0
    takeoff_slope: Annotated[
        float,
        Number(
            "Angle by which the take-off surface rises ahead",
            "DEG",
            -STEEPEST,
            STEEPEST,
            "rad",
        ),
    ] = 0.0
    takeoff_cross_slope: Annotated[
        float,
        Number(
            "Angle by which the take-off surface rises to the left",
            "DEG",
            -STEEPEST,
            STEEPEST,
            "rad",
        ),
    ] = 0.0
    arms: Annotated[
        str,
        Name("Arms, where the robot has some: free, to shape the inertia, or held as they hang"),
    ] = FREE
    payload: Annotated[
        tuple[float, ...],
        Load(
            "Mass on the trunk, up to half of the robot's: kg, and its place in the "
            "trunk's frame, m",
            PAYLOAD,
        ),
    ] = ()
    stones: Annotated[
        tuple[Stone, ...],
        StoneList(
            "Landing place of one leg's foot, m beside where it lands by itself: ahead, to the "
            "left and above, as the robot looks that lands",
            STONE,
        ),
    ] = ()
    route: Annotated[
        tuple[Landing, ...],
        Route(
            "Landings one after the other in place of where to jump and of hops, each from where "
            "the robot stood before: a TOML file with a table [[landing]] for each, of forward, "
            "lateral, height (m), twist, slope and cross_slope (deg)",
            "FILE",
        ),
    ] = ()

    def __post_init__(self) -> None:
        check_fields(self)
        self._check_route()
        if self.arms not in ARMS:
            raise InputError(f'arms: no choice "{self.arms}"; {choices(self.arms, ARMS)}')
        for name in ("roll", "pitch"):
            turns = getattr(self, name) / (2 * math.pi)
            if abs(turns - round(turns)) > _WHOLE:
                raise InputError(
                    f"{name}: {math.degrees(getattr(self, name)):g} deg; expected whole turns: "
                    "-360, 0 or 360 deg (in Python and in files in rad)"
                )

    def _check_route(self) -> None:
        if not self.route:
            return
        beside = [name for name in (*COMPONENTS, *SLOPES) if getattr(self, name)]
        if beside or self.hops > 1:
            raise InputError(
                f"route: the request has {beside[0] if beside else 'hops'}, too; expected that its "
                "landings alone say where to jump"
            )
        changed: dict[str, Any] = {"type": IN_A_ROW} if self.type == PLAIN else {}
        if len(self.route) == 1:  # a plain jump
            changed = self.route[0]._asdict() | {"route": ()}
        for name, value in changed.items():
            object.__setattr__(self, name, value)

    @property
    def jumps(self) -> int:
        """Number of jumps in a row."""
        return len(self.route) or self.hops

    @property
    def landings(self) -> tuple[Landing, ...]:
        """Where it asks its jumps to lead, one after the other."""
        return self.route or self.hops * (
            Landing(*(getattr(self, name) for name in Landing._fields)),
        )

    def along(self, landings: Sequence[Landing]) -> Jump:
        """The same robot along another route, without stones: they were of another last landing.

        What had no route has its type's numbers no more: all feet push, and all land. A route of no
        landing is a jump on the spot.
        """
        if self.route and len(landings) > 1:
            return replace(self, stones=(), route=tuple(landings))
        own: dict[str, Any] = dict.fromkeys((*COMPONENTS, *SLOPES), 0.0)
        own |= {name: getattr(Jump, name) for name in TYPE_PARAMETERS}
        return replace(self, **own, type=PLAIN, stones=(), route=tuple(landings))

    def singly(self, displacement: Sequence[object]) -> tuple[Jump, ...]:
        """The jumps of a row, each by itself, of plain ones.

        `displacement`: where each leads, by the names of its fields; what is None is the request's.
        """
        plain = replace(
            self,
            type=PLAIN,
            hops=1,
            route=(),
            stones=(),
            gap=0.0,
            bar=0.0,
            speed=0.0,
            end_speed=0.0,
        )
        slope, cross_slope = self.takeoff_slope, self.takeoff_cross_slope
        found = []
        for landing in displacement:
            amounts = {name: getattr(landing, name, None) for name in (*COMPONENTS, *SLOPES)}
            own: dict[str, Any] = {
                name: value for name, value in amounts.items() if value is not None
            }
            one = replace(plain, **own, takeoff_slope=slope, takeoff_cross_slope=cross_slope)
            slope, cross_slope = one.slope, one.cross_slope
            found.append(one)
        return (*found[:-1], replace(found[-1], stones=self.stones))

    def on_ground(self, share: float) -> Jump:
        """The same jump with slopes and stones of a share of their size; 0: on level ground."""
        slopes: dict[str, Any] = {name: share * getattr(self, name) for name in INCLINES}
        stones = [Stone(leg, *(share * each for each in place)) for leg, *place in self.stones]
        return replace(self, stones=tuple(stones), **slopes)

    @property
    def turns(self) -> bool:
        """True if the body turns over: a whole turn of roll or pitch."""
        return bool(self.roll or self.pitch)

    def as_dict(self) -> dict[str, Any]:
        """The request as plain data, for files and messages; stones and route where it has some."""
        found = asdict(self) | {
            "payload": list(self.payload),
            "stones": by_leg(self.stones),
            "route": as_rows(self.route),
        }
        return {n: value for n, value in found.items() if value or n not in _STATED_ALONE}


def changes(wanted: Jump, found: Jump) -> str:
    """Difference of a jump from the one that was asked for: "147° instead of 170°".

    Components that look alike are left out, and the name of the twist where nothing else differs.
    """
    values = {name: (_amount(name, found), _amount(name, wanted)) for name in AMOUNTS}
    differ = {name: pair for name, pair in values.items() if pair[0] != pair[1]}
    return ", ".join(
        f"{'' if list(differ) == ['twist'] else name.replace('_', ' ') + ' '}{new} instead of {old}"
        for name, (new, old) in differ.items()
    )


def not_feasible(reason: str, wanted: Jump, nearest: Jump) -> str:
    """That a jump cannot be planned, why, and the nearest one that can, in words."""
    less = changes(wanted, nearest) or "almost the request"
    return f"not feasible: {reason}; nearest: {less}"


def _amount(name: str, jump: Jump) -> str:
    spec, value = field_specs(Jump)[name], getattr(jump, name)
    assert isinstance(spec, Number)
    # A tenth of a degree, a millimetre: less is no difference that a robot makes.
    if spec.unit == "rad":
        return f"{short(round(math.degrees(value), 1))}°"
    return f"{short(round(value, 3))} {spec.unit}"
