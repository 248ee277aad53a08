"""A sweep's spec: a TOML file that lists jumps of robots; docs/cluster.md describes its keys.

A grid has every value of every axis with every other. With `sampling = "random"` or `"sobol"` there
are `count` jumps a robot, model and type, drawn by `seed`, and ranges have no `count`.
"""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from llsrbm.errors import InputError, printable
from llsrbm.installed import assets_directory
from llsrbm.request.jump import Jump
from llsrbm.request.messages import look_up
from llsrbm.request.scenario import Scenario
from llsrbm.request.tables import OneLine, Table, fault, read_table, validated, with_tuples

ROBOT_RANGES = ("twist", "forward", "lateral", "height")
"""Axes whose ranges a robot's file states."""

COUNTED = ("roll", "pitch", "hops")
"""Axes of whole turns and whole numbers: only lists make sense."""

_DEGREES = "_deg"  # end of the name of an axis in degrees
_LARGEST_SEED = 2**63 - 1  # of the table's column

Ranges = Mapping[str, tuple[float, float]]
"""Name -> ends of a robot's range, SI."""


# ---- axes


def _as_axis(given: Any) -> Any:
    """A number or a list as the table of an axis."""
    if given == ():
        raise fault("is empty; expected at least one value")
    if isinstance(given, int | float) and not isinstance(given, bool):
        return {"values": (given,)}
    return {"values": given} if isinstance(given, tuple) else given


class AxisTable(Table):
    """One axis: listed values, or a range, both ends included, of which a grid has `count`."""

    values: Annotated[tuple[float, ...], Field(min_length=1)] | None = None
    low: Annotated[float | None, Field(alias="from")] = None
    high: Annotated[float | None, Field(alias="to")] = None
    range: Literal["robot"] | None = None
    count: Annotated[int, Field(ge=1)] | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        ends = {self.low is not None, self.high is not None}
        given = [self.values is not None, *ends, self.range is not None]
        if len(ends) == 2 or given.count(True) != 1:
            raise fault('expected a list, "from" and "to", or range = "robot"')
        if self.values is not None:
            if self.count is not None:
                raise fault('a list has its values; expected no "count" beside it')
            if len(set(self.values)) < len(self.values):
                raise fault("a value is listed twice; expected each once")
        if self.low is not None and self.high is not None:
            if self.low > self.high:
                raise fault(
                    f"the range from {self.low:g} to {self.high:g} is empty; expected from <= to"
                )
            if self.low == self.high and (self.count or 1) > 1:
                raise fault(f"from and to are both {self.low:g}; expected count = 1, or a range")
        return self


_Axis = Annotated[AxisTable, BeforeValidator(_as_axis)]
_AnyAxis = Annotated[_Axis | None, Field(description="a number, a list or a table")]


class JumpAxes(Table):
    """Axes of a jump's fields, in the order in which a grid runs through them, the last fastest."""

    twist: _AnyAxis = None
    twist_deg: _AnyAxis = None
    forward: _AnyAxis = None
    lateral: _AnyAxis = None
    height: _AnyAxis = None
    roll: _AnyAxis = None
    roll_deg: _AnyAxis = None
    pitch: _AnyAxis = None
    pitch_deg: _AnyAxis = None
    speed: _AnyAxis = None
    end_speed: _AnyAxis = None
    hops: _AnyAxis = None
    slope: _AnyAxis = None
    slope_deg: _AnyAxis = None
    cross_slope: _AnyAxis = None
    cross_slope_deg: _AnyAxis = None
    takeoff_slope: _AnyAxis = None
    takeoff_slope_deg: _AnyAxis = None
    takeoff_cross_slope: _AnyAxis = None
    takeoff_cross_slope_deg: _AnyAxis = None
    gap: _AnyAxis = None
    bar: _AnyAxis = None


class DriveAxes(Table):
    """Axes of the drives' limits, times those of the robot's file."""

    torque: _AnyAxis = None
    speed: _AnyAxis = None


@dataclass(frozen=True)
class Dimension:
    """One axis in SI units: `key` is its name in the table `where`: "axes", "limits", "drives"."""

    where: str
    key: str
    axis: AxisTable

    @property
    def name(self) -> str:
        """A `Jump`'s field, a limit or a property of drives: the key without its unit."""
        return self.key.removesuffix(_DEGREES)

    @property
    def size(self) -> int:
        """Number of its values in a grid."""
        return len(self.axis.values) if self.axis.values is not None else self.axis.count or 1

    def value(self, number: int, ranges: Ranges) -> float:
        """One of a grid's values, SI; `number`: from 0 to `size` - 1."""
        if self.axis.values is not None:
            return self._si(self.axis.values[number])
        low, high = self._ends(ranges)
        steps = self.size - 1
        # The far end is met exactly, and a grid's middle is 0 where that is in the middle.
        return (low * (steps - number) + high * number) / steps if steps else low

    def drawn(self, share: float, ranges: Ranges) -> float:
        """The value, SI, at a share, 0 to 1, of the range, or of the list."""
        if self.axis.values is not None:
            return self.value(min(int(share * self.size), self.size - 1), ranges)
        low, high = self._ends(ranges)
        return low + share * (high - low)

    def check(self, sampling: str) -> None:
        """Refuse an axis that makes no sense in its place."""
        of_jump, axis, place = self.where == "axes", self.axis, f"{self.where}.{self.key}"
        if self.where == "drives" and (axis.values is None or min(axis.values) <= 0):
            # Each has solvers of its own, which take some ten seconds to build.
            raise fault(f"{place}: expected a list of factors above 0, such as [0.8, 1, 1.2]")
        if axis.values is None:
            if of_jump and self.name in COUNTED:
                degrees = "-360, 0" if self.key.endswith(_DEGREES) else "0.0"
                example = "1, 2, 3" if self.name == "hops" else degrees
                raise fault(f"{place}: expected a list of values, such as [{example}]")
            if sampling == "grid" and axis.count is None:
                raise fault(f'{place}: missing "count"; expected how many values a grid has of it')
            if sampling != "grid" and axis.count is not None:
                raise fault(f'{place}: "count" is for grids; expected none with "{sampling}"')
        if axis.range is not None and (not of_jump or self.name not in ROBOT_RANGES):
            raise fault(
                f'{place}: a robot\'s file has no range of it; expected "from" and "to" '
                f'(range = "robot" is for {", ".join(ROBOT_RANGES)})'
            )
        # A field's range has no holes: what lies between two of its values is one, too.
        ends = [end for end in (axis.low, axis.high) if end is not None]
        for value in map(self._si, (axis.values or ends) if of_jump else ()):
            whole = self.name == "hops" and value == int(value)
            field: dict[str, Any] = {self.name: int(value) if whole else value}
            try:
                Jump(**field)
            except InputError as error:
                raise fault(f"{place}: {str(error).partition(': ')[2]}") from error

    def _ends(self, ranges: Ranges) -> tuple[float, float]:
        if self.axis.low is None or self.axis.high is None:
            return ranges[self.name]
        return self._si(self.axis.low), self._si(self.axis.high)

    def _si(self, value: float) -> float:
        in_degrees = self.where == "axes" and self.key.endswith(_DEGREES)
        return math.radians(value) if in_degrees else value


# ---- the spec

_Name = Annotated[str, Field(min_length=1, max_length=1000), OneLine]
_Names = Annotated[tuple[_Name, ...], Field(min_length=1)]
_Simulate = Annotated[
    Literal[False] | dict[str, Any] | None, Field(description="a table of a scenario, or false")
]


class Spec(Table):
    """A sweep's spec; docs/cluster.md has the meaning of each field."""

    title: Annotated[str, Field(min_length=1, max_length=200), OneLine]
    robots: _Names
    models: _Names = (Jump.model,)
    types: _Names = (Jump.type,)
    arms: Literal["free", "held"] | None = None  # of robots that have some; None: free
    sampling: Literal["grid", "random", "sobol"] = "grid"
    count: Annotated[int, Field(ge=1)] | None = None  # jumps a robot, model and type, if drawn
    # Draws jumps, and numbers the disturbances of simulations.
    seed: Annotated[int, Field(ge=0, le=_LARGEST_SEED)] = 0
    axes: JumpAxes = JumpAxes()
    limits: dict[_Name, _Axis] = Field(default_factory=dict)
    drives: DriveAxes = DriveAxes()
    simulate: _Simulate = None
    patient: bool = True  # plans are tried from other guesses where the analytic one fails
    diagnose: bool = False
    trajectories: bool = False  # planned motions are kept, as list columns
    # plans of the first stage alone, unchecked; else plans that are not certified are rows, no more
    draft: bool = False

    @model_validator(mode="after")
    def _check(self) -> Self:
        for name in ("robots", "models", "types"):
            given = getattr(self, name)
            if len(set(given)) < len(given):
                raise fault(f"{name}: one is named twice; expected each once")
        if self.sampling == "grid" and self.count is not None:
            raise fault('count: a grid has its axes\' counts; expected it with "random" or "sobol"')
        if self.sampling != "grid" and self.count is None:
            raise fault(f'count: missing; expected how many jumps to draw with "{self.sampling}"')
        for dimension in self.dimensions():
            dimension.check(self.sampling)
        given = {dimension.key for dimension in self.dimensions() if dimension.where == "axes"}
        for name in sorted(given):
            if name + _DEGREES in given:
                raise fault(f"axes: {name} and {name}{_DEGREES} are the same; expected one of them")
        self.scenario()
        return self

    def dimensions(self) -> Iterator[Dimension]:
        """Axes that are given, the slowest of a grid first."""
        for where, axes in (("drives", self.drives), ("limits", self.limits), ("axes", self.axes)):
            for name, axis in axes.items() if isinstance(axes, dict) else axes:
                if axis is not None:
                    yield Dimension(where, name, axis)

    def scenario(self) -> Scenario | None:
        """The scenario of simulations, seeds aside; None: plan only."""
        if not isinstance(self.simulate, dict):
            return None
        table = dict(self.simulate)
        seeds = table.pop("seeds", None)
        _check_seeds(seeds)
        if "seed" in table:
            raise fault('simulate.seed: expected "seeds", a number of them or a list')
        try:
            scenario = Scenario().but(**table)
            return scenario if seeds is None else scenario.but(seed=0)
        except InputError as error:
            raise fault(f"simulate: {error}") from error

    @property
    def simulated(self) -> bool:
        """True if plans are simulated, too."""
        return isinstance(self.simulate, dict)

    @property
    def _seeds(self) -> Any:
        return self.simulate.get("seeds") if isinstance(self.simulate, dict) else None

    def rows_a_jump(self) -> int:
        """One a seed."""
        return len(self._seeds) if isinstance(self._seeds, tuple) else self._seeds or 1

    def simulation_seed(self, row: int) -> int | None:
        """Seed of the row with that number; None: undisturbed, or not simulated."""
        if isinstance(self._seeds, tuple):
            return int(self._seeds[row % len(self._seeds)])
        return None if self._seeds is None else self.seed + row

    def as_table(self) -> dict[str, Any]:
        """The whole of it, for JSON."""
        return self.model_dump(mode="json", by_alias=True, exclude_none=True)

    @classmethod
    def from_table(cls, table: dict[str, Any]) -> Spec:
        """The spec of an `as_table`."""
        return cls.model_validate(with_tuples(table))

    def digest(self) -> str:
        """The same for specs of the same jumps, whatever their comments, and for those alone."""
        text = self.model_dump_json(by_alias=True, exclude_none=True)
        return hashlib.sha256(text.encode()).hexdigest()


def _check_seeds(seeds: Any) -> None:
    """Refuse seeds that are neither None, a number of them, nor a list of different ones."""
    listed, least = (seeds, 0) if isinstance(seeds, tuple) else ((seeds,), 1)
    good = all(type(seed) is int and least <= seed <= _LARGEST_SEED for seed in listed)
    if seeds is not None and not (good and listed and len(set(listed)) == len(listed)):
        raise fault(
            "simulate.seeds: expected how many of each jump, from 1 on, or a list of different "
            f"seeds from 0 on, got {printable(repr(seeds))}"
        )


# ---- files


def find_spec(name_or_path: str) -> Spec:
    """The spec of that name among those that come with the project, or in the file at that path.

    A text that ends in ".toml" or contains a path separator is a path. Robots and limits are
    checked by `points`. Raises `InputError`: one line: no such name, or the file, the key, its
    value and the accepted ones.
    """
    path = Path(name_or_path)
    if not name_or_path.endswith(".toml") and os.sep not in name_or_path:
        known = {file.stem: file for file in sorted((assets_directory() / "sweeps").glob("*.toml"))}
        path = look_up("sweep", name_or_path, known, "or the path of a spec's file (.toml)")
    return validated(Spec, read_table(path, "a sweep's spec"), str(path))
