"""One axis of a sweep: its values as a file says them, checked, and in SI units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from llsrbm.errors import InputError
from llsrbm.request.jump import Jump
from llsrbm.request.tables import Table

DEGREES = "_deg"
"""What the name of an axis in degrees ends in."""

ROBOT_RANGES = ("twist", "forward", "lateral", "height")
"""Axes of which a robot's file says what may be asked."""

COUNTED = ("roll", "pitch", "hops")
"""Axes of whole turns and whole numbers: only lists make sense."""


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
            raise wrong('expected a list, "from" and "to", or range = "robot"')
        if self.values is not None:
            if self.count is not None:
                raise wrong('a list has its values; expected no "count" beside it')
            if len(set(self.values)) < len(self.values):
                raise wrong("a value is listed twice; expected each once")
        if self.low is not None and self.high is not None:
            if self.low > self.high:
                raise wrong(
                    f"the range from {self.low:g} to {self.high:g} is empty; expected from <= to"
                )
            if self.low == self.high and (self.count or 1) > 1:
                raise wrong(f"from and to are both {self.low:g}; expected count = 1, or a range")
        return self


Axis = Annotated[AxisTable, BeforeValidator(_as_axis)]


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


class Dimension:
    """One axis in SI units.

    Attributes:
        where: the spec's table, "axes", "limits" or "drives".
        name: a `Jump`'s field, a limit or a property of drives.
    """

    def __init__(self, where: str, name: str, axis: AxisTable) -> None:
        self.where, self.name, self._axis = where, name.removesuffix(DEGREES), axis
        self._in_degrees = where == "axes" and name.endswith(DEGREES)

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


def check_axis(where: str, name: str, axis: AxisTable, sampling: str) -> None:
    """Refuse an axis that makes no sense in its place; `where`: table and name."""
    plain = name.removesuffix(DEGREES)
    if axis.values is None:
        if where.startswith("axes.") and plain in COUNTED:
            raise wrong(f"{where}: expected a list of values, such as [{_example(plain, name)}]")
        if sampling == "grid" and axis.count is None:
            raise wrong(f'{where}: missing "count"; expected how many values a grid has of it')
        if sampling != "grid" and axis.count is not None:
            raise wrong(
                f'{where}: "count" is for grids; expected it beside sampling = "{sampling}" alone'
            )
    if axis.range is not None and (not where.startswith("axes.") or plain not in ROBOT_RANGES):
        raise wrong(
            f'{where}: a robot\'s file says nothing of its range; expected "from" and "to" '
            f'(range = "robot" is for {", ".join(ROBOT_RANGES)})'
        )
    if where.startswith("axes."):
        for value in axis.values or ():
            si = math.radians(value) if name.endswith(DEGREES) else value
            try:
                asked: dict[str, Any] = {plain: _whole(si) if plain == "hops" else si}
                Jump(**asked)
            except InputError as error:
                raise wrong(f"{where}: {str(error).partition(': ')[2]}") from error


def check_drives(drives: DriveAxes) -> None:
    """Refuse what no drive can be."""
    for name in names_of(drives):
        axis = getattr(drives, name)
        if axis is not None and (axis.values is None or min(axis.values) <= 0):
            # Each has solvers of its own, which take half a minute to build.
            raise wrong(f"drives.{name}: expected a list of factors above 0, such as [0.8, 1, 1.2]")


def _whole(value: float) -> Any:
    return int(value) if value == int(value) else value


def _example(plain: str, name: str) -> str:
    return "1, 2, 3" if plain == "hops" else "-360, 0" if name.endswith(DEGREES) else "0.0"


def names_of(table: Table) -> list[str]:
    """Of what may stand in a table."""
    return list(type(table).model_fields)


def wrong(message: str) -> PydanticCustomError:
    """An error whose message is complete."""
    return PydanticCustomError("wrong", "{message}", {"message": message})
