"""Jump types: presets in assets/jump_types, or a person's own TOML file in the same form.

    title = "Rear last"
    summary = "the front feet leave first, the hind feet push on"

    [[phase]]
    name = "take-off"
    feet = "all"              # all, none, front, hind, left, right, or names of legs
    time = "takeoff"          # a row of the robot file's [timing], or [shortest, longest], s
    ...

A type says what is contact: the phases, and what of weights and limits they need. Where to, how
fast and how far round is the request's (`llsrbm.Jump`).
"""

from __future__ import annotations

import tomllib
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, ValidationError

from llsrbm.errors import InputError
from llsrbm.robots.assets import assets_directory
from llsrbm.robots.schema import choices
from llsrbm.robots.tables import Table
from llsrbm.schedule import Phase, Schedule

if TYPE_CHECKING:
    from llsrbm.jump import Jump
    from llsrbm.robots.robot import Robot

DEFAULT = "together"
ASKABLE = ("roll", "pitch", "speed", "end_speed", "hops")
"""Fields of a request beyond where to land, which a type may ask for."""

_LARGEST = 100_000  # bytes; a type has a few hundred
_SIDE = 0.3  # of the widest hip's distance from the middle: nearer is neither front nor hind


class PhaseRow(Table):
    """One phase as a file has it.

    Attributes:
        name: as on the timeline.
        feet: "all", "none", "front", "hind", "left", "right", or names of legs.
        time: a row of the robot file's [timing], or shortest and longest duration, s.
        share: of the intervals that a whole phase gets.
        each_hop: whether the phase, with its neighbours that say so too, comes again with every
            further hop; a single hop has none of it.
    """

    name: Annotated[str, Field(min_length=1, max_length=40)]
    feet: str | tuple[str, ...]
    time: str | tuple[float, float]
    share: float = 1.0
    each_hop: bool = False


class Displacement(Table):
    """Where one of several jumps leads, in place of the request's.

    Attributes:
        twist: rad; forward, lateral, height: m.
    """

    twist: float | None = None
    forward: float | None = None
    lateral: float | None = None
    height: float | None = None


class JumpType(Table):
    """A jump type's file.

    Attributes:
        title: name to show; summary: one line.
        asks: what a request of this type says beside where to land, of `ASKABLE`.
        defaults: what it says if it is silent.
        weights, limits: cost or limit name -> value, in place of the robot's.
        displacement: of each jump of several; none: the request's for all.
        phase: in order.
    """

    title: Annotated[str, Field(min_length=1, max_length=40)]
    summary: Annotated[str, Field(min_length=1, max_length=200)]
    asks: tuple[Literal["roll", "pitch", "speed", "end_speed", "hops"], ...] = ()
    defaults: dict[str, float | int] = Field(default_factory=dict)
    weights: dict[str, float] = Field(default_factory=dict)
    limits: dict[str, float] = Field(default_factory=dict)
    displacement: tuple[Displacement, ...] = ()
    phase: Annotated[tuple[PhaseRow, ...], Field(min_length=1)]

    def schedule(self, robot: Robot, hops: int = 1) -> Schedule:
        """The phases with this robot's feet.

        Raises:
            InputError: it has no such feet, or the phases are no schedule.
        """
        if hops > 1 and not any(row.each_hop for row in self.phase):
            raise InputError(
                f'hops: "{self.title}" is one jump; expected 1, or a type with phases of each hop'
            )
        phases: list[Phase] = []
        place = 0
        for row in _repeated(self.phase, hops):
            feet = _feet(row, robot)
            if phases and feet and phases[-1].is_flight:
                place += 1
            phases.append(Phase(row.name, feet, row.time, place, row.share))
        return Schedule(tuple(leg.name for leg in robot.legs), tuple(phases))


def names() -> dict[str, JumpType]:
    """The presets: name -> type, the default first."""
    found = {path.stem: load_type(path.stem) for path in sorted(_directory().glob("*.toml"))}
    return {DEFAULT: found.pop(DEFAULT), **found}


def load_type(name: str) -> JumpType:
    """A preset by its name, or a file by its path.

    Raises:
        InputError: no such preset or file, or not a jump type; one line.
    """
    preset = _directory() / f"{name}.toml"
    if "/" not in name and preset.is_file():
        return _read(preset, preset.stat().st_mtime_ns)
    path = Path(name)
    if path.suffix != ".toml":
        known = [path.stem for path in _directory().glob("*.toml")]
        raise InputError(
            f"unknown jump type {name!r}; {choices(name, known)}, or the path of a .toml file"
        )
    if not path.is_file():
        raise InputError(f"{name}: no such file; expected a jump type (TOML)")
    return _read(path, path.stat().st_mtime_ns)


def schedule_of(jump: Jump, robot: Robot) -> Schedule:
    """The schedule that a request asks for.

    Raises:
        InputError: see `load_type` and `JumpType.schedule`.
    """
    return load_type(jump.type).schedule(robot, jump.hops)


def _directory() -> Path:
    return assets_directory() / "jump_types"


@lru_cache(maxsize=32)
def _read(path: Path, changed: int) -> JumpType:
    """The file's content; `changed`, its time of change, has an edited file read again."""
    try:
        content = path.read_bytes()[:_LARGEST]
        table = tomllib.loads(content.decode())
        return JumpType.model_validate(_with_tuples(table))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"{path}: not a TOML file: {error}") from error
    except ValidationError as error:
        detail = error.errors()[0]
        place = ".".join(str(part) for part in detail["loc"])
        raise InputError(f"{path}: {place}: {detail['msg'].lower()}") from error


def _with_tuples(value: Any) -> Any:
    if isinstance(value, list):
        return tuple(_with_tuples(item) for item in value)
    if isinstance(value, dict):
        return {key: _with_tuples(item) for key, item in value.items()}
    return value


def _repeated(rows: tuple[PhaseRow, ...], hops: int) -> list[PhaseRow]:
    """The rows, runs of `each_hop` as often as there are further hops."""
    phases: list[PhaseRow] = []
    k = 0
    while k < len(rows):
        end = k
        while end < len(rows) and rows[end].each_hop:
            end += 1
        if end > k:
            phases += list(rows[k:end]) * (hops - 1)
            k = end
        else:
            phases.append(rows[k])
            k += 1
    return phases


def _feet(row: PhaseRow, robot: Robot) -> tuple[str, ...]:
    legs = tuple(leg.name for leg in robot.legs)
    if isinstance(row.feet, tuple):
        return row.feet
    if row.feet in ("all", "none"):
        return legs if row.feet == "all" else ()
    groups = _groups(robot)
    if row.feet not in groups:
        if row.feet in legs:
            return (row.feet,)
        accepted = ", ".join(dict.fromkeys(["all", "none", *groups, *legs]))
        raise InputError(
            f'phase "{row.name}": {robot.name} has no {row.feet!r} feet; expected one of {accepted}'
        )
    return groups[row.feet]


def _groups(robot: Robot) -> dict[str, tuple[str, ...]]:
    """The groups of feet that this robot has: name -> legs."""
    hips = robot.hips - robot.hips.mean(axis=0)
    groups = {}
    for axis, ahead, behind in ((0, "front", "hind"), (1, "left", "right")):
        far = _SIDE * abs(hips[:, axis]).max()
        if far < 0.01:  # m: all hips in one line
            continue
        for name, side in ((ahead, 1), (behind, -1)):
            groups[name] = tuple(
                leg.name
                for leg, hip in zip(robot.legs, hips[:, axis], strict=True)
                if side * hip > far
            )
    return groups
