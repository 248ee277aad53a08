"""A sweep's spec: which jumps of which robots, as a TOML file says it.

    title = "ANYmal: twist and distance"
    robots = ["anymal"]              # names or paths of robot files
    models = ["llsrbm-plus"]         # if left out: this one
    types = ["together"]             # likewise

    [axes]                           # in SI units; angles in rad, or in degrees as twist_deg
    twist_deg = { from = -180, to = 180, count = 25 }
    forward = [0.0, 0.2, 0.4]
    height = { range = "robot", count = 7 }      # all that the robot's file says may be asked

    [limits]                         # limit name -> values, see `llsrbm tuning`
    friction = [0.3, 0.5]

    [drives]                         # times what the robot's file says
    torque = [0.8, 1.0, 1.2]

    [simulate]                       # without: plan only
    seeds = 3                        # of each jump, all different; a list: these for every jump

A grid has every value of every axis with every other. With `sampling = "random"` or `"sobol"` there
are `count` jumps a robot, model and type, drawn by `seed`, and ranges have no `count`.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, ValidationError, model_validator
from pydantic_core import ErrorDetails, PydanticCustomError

from llsrbm.errors import InputError, printable
from llsrbm.jump import Jump
from llsrbm.robots.assets import assets_directory
from llsrbm.robots.schema import choices
from llsrbm.robots.tables import Table, with_tuples
from llsrbm.scenario import Scenario

SUFFIX = ".toml"
ROBOT_RANGES = ("twist", "forward", "lateral", "height")
"""Axes of which a robot's file says what may be asked."""

COUNTED = ("roll", "pitch", "hops")
"""Axes of whole turns and whole numbers: only lists make sense."""

_LARGEST = 1_000_000  # bytes; a spec has a few hundred
_DEGREES = "_deg"
_LARGEST_SEED = 2**63 - 1  # what the table's column holds


def _as_axis(given: Any) -> Any:
    """A number or a list as the table of an axis."""
    if isinstance(given, int | float) and not isinstance(given, bool):
        return {"values": (given,)}
    return {"values": given} if isinstance(given, tuple) else given


class AxisTable(Table):
    """One axis: listed values, or a range.

    Attributes:
        values: listed.
        low, high: the ends of a range, both included; "from" and "to" in files.
        range: "robot": all that the robot's file says may be asked.
        count: of a grid's values in a range, evenly spaced.
    """

    values: Annotated[tuple[float, ...], Field(min_length=1)] | None = None
    low: Annotated[float | None, Field(alias="from")] = None
    high: Annotated[float | None, Field(alias="to")] = None
    range: Literal["robot"] | None = None
    count: Annotated[int, Field(ge=1)] | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        ends = (self.low is not None, self.high is not None)
        if (self.values is not None, all(ends), self.range is not None).count(True) != 1 or (
            any(ends) != all(ends)
        ):
            raise _said('expected a list, "from" and "to", or range = "robot"')
        if self.values is not None:
            if self.count is not None:
                raise _said('a list has its values; expected no "count" beside it')
            if len(set(self.values)) < len(self.values):
                raise _said("a value is listed twice; expected each once")
        if self.low is not None and self.high is not None:
            if self.low > self.high:
                raise _said(
                    f"the range from {self.low:g} to {self.high:g} is empty; expected from <= to"
                )
            if self.low == self.high and (self.count or 1) > 1:
                raise _said(f"from and to are both {self.low:g}; expected count = 1, or a range")
        return self


Axis = Annotated[AxisTable, BeforeValidator(_as_axis)]
_OneLine = AfterValidator(lambda text: _printable(text))
_Name = Annotated[str, Field(min_length=1, max_length=1000), _OneLine]
_Names = Annotated[tuple[_Name, ...], Field(min_length=1)]


class JumpAxes(Table):
    """Axes of a jump's fields, in the order in which a grid runs through them, the last fastest."""

    twist: Axis | None = None
    twist_deg: Axis | None = None
    forward: Axis | None = None
    lateral: Axis | None = None
    height: Axis | None = None
    roll: Axis | None = None
    roll_deg: Axis | None = None
    pitch: Axis | None = None
    pitch_deg: Axis | None = None
    speed: Axis | None = None
    end_speed: Axis | None = None
    hops: Axis | None = None


class DriveAxes(Table):
    """Axes of what the drives can do, times what the robot's file says."""

    torque: Axis | None = None
    speed: Axis | None = None


class Spec(Table):
    """A sweep's spec.

    Attributes:
        title: one line.
        robots, models, types: names or paths, as a `Jump` has them.
        sampling: how axes are combined; count: jumps a robot, model and type of a drawn sweep.
        seed: draws jumps, and numbers the disturbances of simulations (`seeds`).
        axes, limits, drives: what varies; what is not named is as the robot has it.
        simulate: fields of a `Scenario`, with `seeds`; None or false: plan only.
        patient: whether plans are tried from other guesses where the analytic one fails.
        diagnose: whether the limit that stops a jump is looked for, which takes some seconds each.
        trajectories: whether planned motions are kept, as zarr.
    """

    title: Annotated[str, Field(min_length=1, max_length=200), _OneLine]
    robots: _Names
    models: _Names = (Jump.model,)
    types: _Names = (Jump.type,)
    sampling: Literal["grid", "random", "sobol"] = "grid"
    count: Annotated[int, Field(ge=1)] | None = None
    seed: Annotated[int, Field(ge=0, le=_LARGEST_SEED)] = 0
    axes: JumpAxes = JumpAxes()
    limits: dict[_Name, Axis] = Field(default_factory=dict)
    drives: DriveAxes = DriveAxes()
    simulate: Literal[False] | dict[str, Any] | None = None
    patient: bool = True
    diagnose: bool = False
    trajectories: bool = False

    @model_validator(mode="after")
    def _check(self) -> Self:
        for name in ("robots", "models", "types"):
            given = getattr(self, name)
            if len(set(given)) < len(given):
                raise _said(f"{name}: one is named twice; expected each once")
        if self.sampling == "grid" and self.count is not None:
            raise _said('count: a grid has its axes\' counts; expected it with "random" or "sobol"')
        if self.sampling != "grid" and self.count is None:
            raise _said(f'count: missing; expected how many jumps to draw with "{self.sampling}"')
        for where, name, axis in self._given():
            _check_axis(f"{where}.{name}", name, axis, self.sampling)
        for name in ("twist", "roll", "pitch"):
            if getattr(self.axes, name) and getattr(self.axes, name + _DEGREES):
                raise _said(f"axes: {name} and {name}{_DEGREES} are the same; expected one of them")
        _check_drives(self.drives)
        self.scenario()
        return self

    def _given(self) -> Iterator[tuple[str, str, AxisTable]]:
        """Table, name and axis of all that are given, the slowest of a grid first."""
        for where, table in (("drives", self.drives), ("limits", None), ("axes", self.axes)):
            named = self.limits if table is None else {n: getattr(table, n) for n in _fields(table)}
            for name, axis in named.items():
                if axis is not None:
                    yield where, name, axis

    def dimensions(self) -> list[Dimension]:
        """What varies, in SI units, the slowest of a grid first."""
        return [Dimension(where, name, axis) for where, name, axis in self._given()]

    def scenario(self) -> Scenario | None:
        """What simulations are asked for, seeds aside; None: plan only."""
        if not self.simulated:
            return None
        table: dict[str, Any] = dict(self.simulate or {})
        seeds = table.pop("seeds", None)
        _check_seeds(seeds)
        if "seed" in table:
            raise _said('simulate.seed: expected "seeds", a number of them or a list')
        try:
            scenario = Scenario().but(**table)
            return scenario if seeds is None else scenario.but(seed=0)
        except InputError as error:
            raise _said(f"simulate: {error}") from error

    @property
    def simulated(self) -> bool:
        """Whether plans are simulated, too."""
        return self.simulate is not None and self.simulate is not False

    def rows_a_jump(self) -> int:
        """One a seed."""
        seeds = self.simulate.get("seeds") if isinstance(self.simulate, dict) else None
        return len(seeds) if isinstance(seeds, tuple) else seeds or 1

    def simulation_seed(self, row: int) -> int | None:
        """Of the row with that number; None: undisturbed, or not simulated."""
        seeds = self.simulate.get("seeds") if isinstance(self.simulate, dict) else None
        if isinstance(seeds, tuple):
            return int(seeds[row % len(seeds)])
        return None if seeds is None else self.seed + row

    def as_json(self) -> str:
        """The whole of it, to be sent or compared."""
        return self.model_dump_json(by_alias=True, exclude_none=True)

    @classmethod
    def from_json(cls, text: str) -> Spec:
        """What `as_json` wrote."""
        return cls.model_validate(with_tuples(json.loads(text)))

    def digest(self) -> str:
        """The same for specs that ask the same, whatever their comments, and for those alone."""
        return hashlib.sha256(self.as_json().encode()).hexdigest()


class Dimension:
    """One axis in SI units.

    Attributes:
        where: the spec's table, "axes", "limits" or "drives".
        name: a `Jump`'s field, a limit or a property of drives.
    """

    def __init__(self, where: str, name: str, axis: AxisTable) -> None:
        self.where, self.name, self._axis = where, name.removesuffix(_DEGREES), axis
        self._in_degrees = where == "axes" and name.endswith(_DEGREES)

    @property
    def size(self) -> int:
        """How many values a grid has of it."""
        axis = self._axis
        return len(axis.values) if axis.values is not None else axis.count or 1

    def value(self, number: int, ranges: Mapping[str, tuple[float, float]]) -> float:
        """One of a grid's values.

        Args:
            number: from 0 to `size` - 1.
            ranges: what the robot's file says may be asked, by name, SI.
        """
        if self._axis.values is not None:
            return self._si(self._axis.values[number])
        low, high = self._ends(ranges)
        steps = self.size - 1
        # The far end is met exactly, and a grid's middle is 0 where that is in the middle.
        return (low * (steps - number) + high * number) / steps if steps else low

    def drawn(self, share: float, ranges: Mapping[str, tuple[float, float]]) -> float:
        """The value at a share, 0 to 1, of the range, or of the list."""
        if self._axis.values is not None:
            count = len(self._axis.values)
            return self._si(self._axis.values[min(int(share * count), count - 1)])
        low, high = self._ends(ranges)
        return low + share * (high - low)

    def _ends(self, ranges: Mapping[str, tuple[float, float]]) -> tuple[float, float]:
        if self._axis.range is not None:
            return ranges[self.name]
        assert self._axis.low is not None
        assert self._axis.high is not None
        return self._si(self._axis.low), self._si(self._axis.high)

    def _si(self, value: float) -> float:
        return math.radians(value) if self._in_degrees else value


def find_spec(name_or_path: str) -> Spec:
    """The spec of that name among those that come with the project, or in the file at that path.

    What ends in ".toml" or contains a path separator is a path.

    Raises:
        InputError: no such name, or the file is no spec; one line that says what is accepted.
    """
    if name_or_path.endswith(SUFFIX) or os.sep in name_or_path:
        return read_spec(Path(name_or_path))
    known = {path.stem: path for path in sorted((assets_directory() / "sweeps").glob("*.toml"))}
    if name_or_path not in known:
        raise InputError(
            f'no sweep "{name_or_path}"; {choices(name_or_path, known)}, '
            "or the path of a spec's file (.toml)"
        )
    return read_spec(known[name_or_path])


def read_spec(path: Path) -> Spec:
    """Read and check a spec; whether there are such robots and limits is said by `points`.

    Raises:
        InputError: one line naming the file, the key, what was given and what is accepted.
    """
    try:
        with path.open("rb") as file:
            content = file.read(_LARGEST + 1)
        if len(content) > _LARGEST:
            raise InputError(f"{path}: too large for a sweep's spec; at most {_LARGEST} bytes")
        return parse_spec(content.decode(), str(path))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not a text file in UTF-8") from error


def parse_spec(text: str, where: str) -> Spec:
    """A spec from the text of its file; `where` is what messages call it.

    Raises:
        InputError: as `read_spec`.
    """
    try:
        table = tomllib.loads(text)
    except RecursionError as error:
        raise InputError(f"{where}: not a TOML file: nested too deeply") from error
    except ValueError as error:  # TOMLDecodeError, or a number of thousands of digits
        told = str(error).partition("; use sys.")[0]
        raise InputError(f"{where}: not a TOML file: {printable(told, 200)}") from error
    try:
        return Spec.model_validate(with_tuples(table))
    except ValidationError as error:
        # A misspelt key is both unknown and missing; the first says more.
        details = sorted(error.errors(), key=lambda detail: detail["type"] != "extra_forbidden")
        raise InputError(f"{where}: {_sentence(details[0])}") from error


def _check_axis(where: str, name: str, axis: AxisTable, sampling: str) -> None:
    plain = name.removesuffix(_DEGREES)
    if axis.values is None:
        if where.startswith("axes.") and plain in COUNTED:
            raise _said(f"{where}: expected a list of values, such as [{_example(plain, name)}]")
        if sampling == "grid" and axis.count is None:
            raise _said(f'{where}: missing "count"; expected how many values a grid has of it')
        if sampling != "grid" and axis.count is not None:
            raise _said(
                f'{where}: "count" is for grids; expected it beside sampling = "{sampling}" alone'
            )
    if axis.range is not None and (not where.startswith("axes.") or plain not in ROBOT_RANGES):
        raise _said(
            f'{where}: a robot\'s file says nothing of its range; expected "from" and "to" '
            f'(range = "robot" is for {", ".join(ROBOT_RANGES)})'
        )
    if where.startswith("axes."):
        for value in axis.values or ():
            si = math.radians(value) if name.endswith(_DEGREES) else value
            try:
                asked: dict[str, Any] = {plain: _whole(si) if plain == "hops" else si}
                Jump(**asked)
            except InputError as error:
                raise _said(f"{where}: {str(error).partition(': ')[2]}") from error


def _check_drives(drives: DriveAxes) -> None:
    for name in _fields(drives):
        axis = getattr(drives, name)
        if axis is not None and (axis.values is None or min(axis.values) <= 0):
            # Each has solvers of its own, which take half a minute to build.
            raise _said(f"drives.{name}: expected a list of factors above 0, such as [0.8, 1, 1.2]")


def _check_seeds(seeds: Any) -> None:
    """Whether they are a number of seeds or a list of them; None: none."""
    listed = seeds if isinstance(seeds, tuple) else (seeds,)
    whole = all(isinstance(seed, int) and not isinstance(seed, bool) for seed in listed)
    if seeds is None or (
        whole
        and listed
        and len(set(listed)) == len(listed)
        and min(listed) >= (0 if listed is seeds else 1)
        and max(listed) <= _LARGEST_SEED
    ):
        return
    raise _said(
        "simulate.seeds: expected how many of each jump, from 1 on, or a list of different seeds "
        f"from 0 on, got {printable(repr(seeds))}"
    )


def _whole(value: float) -> Any:
    return int(value) if value == int(value) else value


def _example(plain: str, name: str) -> str:
    return "1, 2, 3" if plain == "hops" else "-360, 0" if name.endswith(_DEGREES) else "0.0"


def _fields(table: Table) -> list[str]:
    return list(type(table).model_fields)


def _printable(text: str) -> str:
    if not text.isprintable():
        raise PydanticCustomError("text", "expected one line of printable text")
    return text


def _said(message: str) -> PydanticCustomError:
    """An error whose words are all there is to say."""
    return PydanticCustomError("said", "{message}", {"message": message})


def _sentence(detail: ErrorDetails) -> str:
    """One pydantic complaint as: key, what was wrong, what would be accepted."""
    # A list is the table's "values", whether its file says so or not.
    hidden = {"values"} if detail["type"] != "extra_forbidden" else set()
    location = [
        f"value {part + 1}" if isinstance(part, int) else part
        for part in detail["loc"]
        if not _is_alternative(part) and part not in hidden
    ]
    key, last = printable(".".join(location)), location[-1] if location else ""
    given = printable(repr(detail["input"]))
    match detail["type"]:
        case "extra_forbidden":
            return f'unknown key "{key}"; {choices(last, _keys(location[:-1]))}'
        case "missing":
            return f'missing key "{key}"; expected: {", ".join(_keys(location[:-1]))}'
        case "said":
            return f"{key}: {detail['msg']}" if location else detail["msg"]
        case "model_type" | "dict_type" | "model_attributes_type" if location[:1] == ["axes"]:
            return f"{key}: expected a number, a list or a table, got {given}"
        case "model_type" | "dict_type" | "model_attributes_type" | "literal_error" if (
            last != "sampling"
        ):
            return f"{key}: expected a table, got {given}"
        case "too_short":
            return f"{key}: is empty; expected at least one value"
        case "tuple_type":
            return f"{key}: expected a list, got {given}"
        case _:
            message = detail["msg"][:1].lower() + detail["msg"][1:]
            return f"{key}: {message}, got {given}"


def _keys(location: list[str]) -> list[str]:
    """What may stand in the table at a location."""
    tables: dict[str, type[Table]] = {"axes": JumpAxes, "drives": DriveAxes}
    table: type[Table] = Spec
    if len(location) == 1:
        table = tables.get(location[0], AxisTable)
    elif location:
        table = AxisTable
    return [info.alias or name for name, info in table.model_fields.items()]


def _is_alternative(part: str | int) -> bool:
    """Whether a part of pydantic's location names one of several kinds that a value may be of."""
    text = str(part)
    return "[" in text or text in ("AxisTable", "tuple", "[key]")
