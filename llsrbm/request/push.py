"""A push: an impulse and a moment on the trunk, at one moment of a simulation."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

from llsrbm.errors import InputError
from llsrbm.request.messages import FieldSpec, Number

DURATION = 0.02  # s that a push takes: one by hand is longer, one by a ball shorter
LARGEST_IMPULSE = 200.0  # N s; it throws the heaviest robot here, of 54 kg, aside with 4 m/s
LARGEST_MOMENT = 50.0  # N m s
MOST_PUSHES = 100  # of one simulation: a page and a file hold them all

SYMBOL = "T,JX,JY,JZ[,MX,MY,MZ]"
"""How a push is written in a line of text: `Push`'s numbers in their order."""

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Push:
    """A constant wrench on the trunk's CoM over `DURATION`.

    Raises:
        InputError: numbers that are not finite or too large, or a time before the start.
    """

    time: float  # s since the plan's start, when it begins
    impulse: Vector  # N s, world frame: the integral of its force
    # N m s, world frame: the integral of its moment about the trunk's CoM.
    moment: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", Number("").checked("push: time", self.time))
        if self.time < 0:
            raise InputError(f"push: time: expected at least 0 s, got {self.time:g}")
        for name, highest, unit in (
            ("impulse", LARGEST_IMPULSE, "N s"),
            ("moment", LARGEST_MOMENT, "N m s"),
        ):
            vector = _vector(name, getattr(self, name))
            size = math.hypot(*vector)
            if size > highest:
                raise InputError(
                    f"push: {name}: expected at most {highest:g} {unit}, got {size:g} {unit}"
                )
            object.__setattr__(self, name, vector)


@dataclass(frozen=True)
class PushList(FieldSpec):
    """Any number of pushes: `Push`es, or mappings of their fields as files have them."""

    def checked(self, name: str, value: Any) -> tuple[Push, ...]:
        """A tuple of pushes."""
        if isinstance(value, str | bytes | Mapping) or not isinstance(value, Sequence):
            raise InputError(f"{name}: expected a list of pushes, got {reprlib.repr(value)}")
        if len(value) > MOST_PUSHES:
            raise InputError(f"{name}: expected at most {MOST_PUSHES}, got {len(value)}")
        return tuple(_push(name, each) for each in value)


def parse_push(text: str) -> Push:
    """The push that a line of text means: "0.4,0,12,0".

    Raises:
        InputError: not four or seven numbers, or not those of a push.
    """
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (4, 7):
        raise InputError(f"push: expected {SYMBOL} in s, N s and N m s, got {reprlib.repr(text)}")
    time, *wrench = numbers
    moment = wrench[3:] or (0.0, 0.0, 0.0)
    return Push(time, _vector("impulse", wrench[:3]), _vector("moment", moment))


def _vector(name: str, value: Any) -> Vector:
    """Three finite numbers, as Python's own."""
    try:
        x, y, z = (Number("").checked(name, each) for each in value)
    except (TypeError, ValueError, InputError):
        raise InputError(
            f"push: {name}: expected three finite numbers, got {reprlib.repr(value)}"
        ) from None
    return x, y, z


def _push(name: str, value: Any) -> Push:
    if isinstance(value, Push):
        return value
    known = [field.name for field in fields(Push)]
    least = set(known[:2])
    if not isinstance(value, Mapping) or not least <= set(value) <= set(known):
        raise InputError(
            f"{name}: expected pushes of {', '.join(known)}, got {reprlib.repr(value)}"
        )
    return Push(**value)
