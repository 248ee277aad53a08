"""Jump types: presets in assets/jump_types, or a person's own TOML file in the same form.

docs/jump_types.md describes it. A type says what is contact: the phases, and what of weights and
limits they need. Where to, how fast and how far round is the request's (`llsrbm.Jump`);
`with_defaults` adds what it leaves to its type. A file that is read never has a type's file opened
that it names; planning has.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from functools import cache, lru_cache
from itertools import groupby
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol

from pydantic import Field, model_validator

from llsrbm.arrays import Array
from llsrbm.errors import InputError, printable
from llsrbm.installed import assets_directory
from llsrbm.request.feet_order import is_order, table_of
from llsrbm.request.jump import PLAIN, Jump
from llsrbm.request.jump import TYPE_PARAMETERS as TYPE_PARAMETERS
from llsrbm.request.messages import check_kind, choices
from llsrbm.request.obstacle import wrong_shape
from llsrbm.request.schedule import LONGEST_NAME, Phase, Schedule
from llsrbm.request.tables import OneLine, Table, fault, read_table, validated

_TURNS = ("roll", "pitch")  # alternatives: a request that says one of them is not silent
_SIDE = 0.3  # of the widest hip's distance from the middle: nearer is neither front nor hind
_FEET = "all, none, front, hind, left, right, pivot, lead, or an array of legs' names"
# Sides of a body that turns over: about which it turns, and the other one.
_TURNING_FEET = ("pivot", "lead")
_TIME = "takeoff, flight, landing, or [shortest, longest] in s"


class Legs(Protocol):
    """A robot, as far as a schedule depends on it."""

    @property
    def name(self) -> str:
        """Short name."""

    @property
    def leg_names(self) -> tuple[str, ...]:
        """(L,) in the robot's order."""

    @property
    def hips(self) -> Array:
        """(L, 3) m, base frame."""


class PhaseRow(Table):
    """One phase as a file has it."""

    # As on the timeline.
    name: Annotated[str, Field(min_length=1, max_length=LONGEST_NAME), OneLine]
    # "all", "none", "front", "hind", "left", "right", "pivot", "lead" or names of legs. On its
    # pivot a body that turns over stands last: hind feet in a back flip, front feet in a front
    # flip. Its lead are the other ones, which leave first.
    feet: Annotated[str | tuple[str, ...], Field(description=_FEET)]
    # a row of the robot file's [timing], or shortest and longest duration, s.
    time: Annotated[str | tuple[float, float], Field(description=_TIME)]
    share: float = 1.0  # of the intervals that a whole phase gets
    # Whether the phase, with its neighbours that say so too, comes again with every further hop; a
    # single hop has none of it.
    each_hop: bool = False


class Displacement(Table):
    """Where one of several jumps leads, in place of the request's."""

    twist: float | None = None  # rad
    forward: float | None = None  # m
    lateral: float | None = None  # m
    height: float | None = None  # m


class ObstacleRow(Table):
    """A hurdle or a gap as a file has it; a request's `gap` says how wide, its `bar` how high."""

    # m ahead of the foremost contact point at the start.
    near: Annotated[float, Field(alias="from")]
    far: Annotated[float | None, Field(alias="to")] = None
    height: float | None = None  # m above the ground at the start; below zero: a gap, so deep

    def ends(self, jump: Jump) -> tuple[float, float, float]:
        """From where to where, m ahead, and how high, m, of a request."""
        far = self.near + jump.gap if self.far is None else self.far
        return self.near, far, jump.bar if self.height is None else self.height


class JumpType(Table):
    """A jump type's file."""

    title: Annotated[str, Field(min_length=1, max_length=LONGEST_NAME), OneLine]  # name to show
    summary: Annotated[str, Field(min_length=1, max_length=200), OneLine]  # one line
    # Fields of a request of this type beside where to land.
    parameters: Annotated[
        tuple[Literal["roll", "pitch", "speed", "end_speed", "hops", "gap", "bar"], ...],
        Field(alias="asks", description=f"some of {', '.join(TYPE_PARAMETERS)}"),
    ] = ()
    defaults: dict[str, float | int] = Field(default_factory=dict)  # what it says if it is silent
    # Names of the types that requests with other whole turns are of, which need other limits.
    instead: dict[Literal["roll", "pitch"], str] = Field(default_factory=dict)
    weights: dict[str, float] = Field(default_factory=dict)  # in place of the robot's
    limits: dict[str, float] = Field(default_factory=dict)  # likewise
    displacement: tuple[Displacement, ...] = ()  # of each jump of several; none: the request's
    obstacle: ObstacleRow | None = None  # what is jumped over, if anything
    # Whether all feet end beyond the obstacle; then it says how far the jumps lead, in two flights
    # of a robot with front and hind feet, which stands astride in between, in one of another.
    passes: bool = False
    clears_ground: bool = False  # whether trunk and knees have to be kept off the ground
    phase: Annotated[tuple[PhaseRow, ...], Field(min_length=1)]  # in order

    @model_validator(mode="after")
    def _check_defaults(self) -> JumpType:
        for name in self.defaults:
            if name not in self.parameters:
                known = ", ".join(self.parameters) or "nothing"
                key = f"defaults.{printable(name)}"
                raise fault(f'{key}: the type asks for {known}; expected one of "asks"')
        try:
            self.default_jump()
        except InputError as error:
            raise fault(str(error)) from error
        return self

    @model_validator(mode="after")
    def _check_obstacle(self) -> JumpType:
        row = self.obstacle
        if row is None:
            if self.passes:
                raise fault('passes: there is nothing to pass; expected a table "obstacle"')
            return self
        for key, value, name in (("to", row.far, "gap"), ("height", row.height, "bar")):
            if (value is None) != (name in self.parameters):
                raise fault(f'obstacle.{key}: expected it, or "{name}" in "asks", and not both')
        why = wrong_shape(*row.ends(self.default_jump()))
        if why:
            raise fault(f"obstacle: {why}")
        return self

    def default_jump(self) -> Jump:
        """A request of its defaults."""
        values: dict[str, Any] = {**self.defaults}
        return replace(Jump(), **values)

    @property
    def clears(self) -> bool:
        """True if the whole body has something to clear, not the feet alone."""
        return self.clears_ground or self.obstacle is not None

    def schedule(self, robot: Legs, jump: Jump | None = None) -> Schedule:
        """The phases with this robot's feet, hops and turn of a request; None: the type's defaults.

        Raises `InputError`: it has no such feet, or the phases are no schedule.
        """
        jump = jump or self.default_jump()
        hops = jump.jumps
        if self.passes:
            if jump.hops > 1:
                raise InputError(
                    f'hops: "{self.title}" flies as often as takes all feet across; '
                    f"expected 1, got {jump.hops}"
                )
            hops = 2 if "front" in _groups(robot) else 1
        if hops > 1 and not any(row.each_hop for row in self.phase):
            raise InputError(
                f'hops: "{self.title}" is one jump; expected 1, or a type with phases of each hop'
            )
        phases: list[Phase] = []
        place = 0
        for row in _repeated(self.phase, hops):
            feet = _feet(row, robot, _sides(jump))
            if phases and feet and phases[-1].is_flight:
                place += 1
            phases.append(Phase(row.name, feet, row.time, place, row.share))
        return Schedule(robot.leg_names, tuple(phases))


def names() -> dict[str, JumpType]:
    """The presets: name -> type, the default first."""
    found = {name: _current(path) for name, path in _presets().items()}
    return {PLAIN: found.pop(PLAIN), **found}


def load_type(name: str) -> JumpType:
    """A preset by its name, a file by its path, or the order in which feet stand.

    Raises `InputError`: no such preset or file, or not a jump type; one line.
    """
    presets = _presets()
    if name in presets:
        return _current(presets[name])
    if is_order(name):
        return _of_order(name)
    path = Path(name)
    if path.suffix != ".toml":
        raise InputError(
            f'unknown jump type "{printable(name)}"; {choices(name, sorted(presets))}, the path of '
            'a .toml file, or an order of feet such as "all - right - none - right - all"'
        )
    if not path.exists():
        raise InputError(f"{printable(name, 200)}: no such file; expected a jump type (TOML)")
    return _current(path)


def schedule_of(jump: Jump, robot: Legs) -> Schedule:
    """The schedule that a request asks for. Raises `InputError`: see `load_type` and
    `JumpType.schedule`.
    """
    return load_type(jump.type).schedule(robot, jump)


def of_its_type(jump: Jump) -> Jump:
    """The request, of the type that its whole turn is of: "flip" with a roll is a barrel roll.

    Raises `InputError`: it is no request, or see `load_type`.
    """
    check_kind("jump", jump, Jump, "a Jump: llsrbm.plan(llsrbm.Jump(...))")
    for name, other in load_type(jump.type).instead.items():
        if getattr(jump, name):
            return replace(jump, type=other)
    return jump


def with_defaults(jump: Jump, given: Collection[str] = ()) -> Jump:
    """The request with its type's defaults (or `Jump`'s) in `TYPE_PARAMETERS` that are not `given`.

    A roll is enough of a turn: a request that has one keeps its pitch, and the other way round. A
    route says itself how many jumps there are.
    Raises `InputError`: see `load_type`.
    """
    jump = of_its_type(jump)
    defaults = load_type(jump.type).defaults
    turned = any(name in given for name in _TURNS)
    plain = Jump().as_dict()
    silent: dict[str, Any] = {
        name: plain[name] if turned and name in _TURNS else defaults.get(name, plain[name])
        for name in TYPE_PARAMETERS
        if name not in given and not (jump.route and name == "hops")
    }
    return replace(jump, **silent)


@cache
def _presets() -> Mapping[str, Path]:
    """Name -> file, by name. Kept: the page asks at each step of a slider."""
    return {path.stem: path for path in sorted((assets_directory() / "jump_types").glob("*.toml"))}


def _current(path: Path) -> JumpType:
    """The type in a file as it is since its last change."""
    try:
        return _read(path, path.stat().st_mtime_ns)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error


@lru_cache(maxsize=32)
def _of_order(order: str) -> JumpType:
    return validated(JumpType, table_of(order), f'jump type "{printable(order)}"')


@lru_cache(maxsize=32)
def _read(path: Path, _changed_ns: int) -> JumpType:
    return validated(JumpType, read_table(path, "a jump type"), str(path))


def _repeated(rows: tuple[PhaseRow, ...], hops: int) -> Iterator[PhaseRow]:
    """The rows, runs of `each_hop` as often as there are further hops."""
    for again, run in groupby(rows, key=lambda row: row.each_hop):
        yield from list(run) * (hops - 1 if again else 1)


def _sides(jump: Jump) -> dict[str, str]:
    """The side about which a body turns over, which goes down as the other one rises, and that
    other one; none of a body that does not.
    """
    if jump.pitch:
        sides = ("hind", "front") if jump.pitch < 0 else ("front", "hind")
    elif jump.roll:
        sides = ("right", "left") if jump.roll > 0 else ("left", "right")
    else:
        return {}
    return dict(zip(_TURNING_FEET, sides, strict=True))


def _feet(row: PhaseRow, robot: Legs, sides: Mapping[str, str]) -> tuple[str, ...]:
    legs = robot.leg_names
    if isinstance(row.feet, tuple):
        return row.feet
    if row.feet in ("all", "none"):
        return legs if row.feet == "all" else ()
    groups = _groups(robot)
    if row.feet in _TURNING_FEET and not sides:
        raise InputError(
            f'phase "{row.name}": "{row.feet}" are feet of a body that turns over; expected a '
            "whole turn of pitch or roll (-360 deg of pitch: a back flip)"
        )
    name = sides.get(row.feet, row.feet) if isinstance(row.feet, str) else row.feet
    if name not in groups:
        if row.feet in legs:
            return (row.feet,)
        accepted = ", ".join(dict.fromkeys(["all", "none", *groups, *legs]))
        raise InputError(
            f'phase "{row.name}": {robot.name} has no {name!r} feet; expected one of {accepted}'
        )
    return groups[name]


def _groups(robot: Legs) -> dict[str, tuple[str, ...]]:
    """The groups of feet that this robot has: name -> legs."""
    hips = robot.hips - robot.hips.mean(axis=0)
    groups = {}
    for axis, ahead, behind in ((0, "front", "hind"), (1, "left", "right")):
        far = _SIDE * abs(hips[:, axis]).max()
        if far < 0.01:  # m: all hips in one line
            continue
        for name, side in ((ahead, 1), (behind, -1)):
            groups[name] = tuple(
                leg
                for leg, hip in zip(robot.leg_names, hips[:, axis], strict=True)
                if side * hip > far
            )
    return groups
