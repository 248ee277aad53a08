"""Stones: where single feet land, beside where they would land by themselves."""

import reprlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from llsrbm.errors import InputError
from llsrbm.request.messages import FieldSpec, Name, Number

STONE = "LEG,DX,DY[,DZ]"
"""How a stone is written in a line of text."""

FARTHEST = 1.0  # m, beyond any robot; whether the leg reaches so far is checked when it plans
MOST = 100  # legs


class Stone(NamedTuple):
    """Where one foot lands beside its default landing place: m, axes of the robot that lands."""

    leg: str
    dx: float  # ahead
    dy: float  # to the left
    dz: float = 0.0  # above the surface on which the other feet land


@dataclass(frozen=True)
class StoneList(FieldSpec):
    """Any number of `Stone`s, or leg -> two or three numbers as files have them.

    They are sorted by their legs, each leg once; one that is nowhere but at the default is left
    out.
    """

    def checked(self, name: str, value: Any) -> tuple[Stone, ...]:
        """See `FieldSpec`; whether the robot has such legs is checked when it plans."""
        rows = stone_rows(value)
        if isinstance(rows, str | bytes | Mapping) or not isinstance(rows, Iterable):
            raise _refused(name, value)
        stones = sorted(_stone(name, row) for row in rows)
        legs = [stone.leg for stone in stones]
        if len(legs) > MOST:
            raise InputError(f"{name}: expected at most {MOST}, got {len(legs)}")
        twice = next((leg for leg in legs if legs.count(leg) > 1), None)
        if twice is not None:
            raise InputError(f"{name}: {twice} is named twice; expected every leg once")
        return tuple(stone for stone in stones if any(stone[1:]))


def stone_rows(value: Any) -> Any:
    """The rows (leg, dx, dy, dz) of stones by their legs; all else as it is."""
    if not isinstance(value, Mapping):
        return value
    listed = (list, tuple)
    return [(leg, *(at if isinstance(at, listed) else (at,))) for leg, at in value.items()]


def by_leg(stones: Iterable[Stone]) -> dict[str, list[float]]:
    """Stones as files have them."""
    return {leg: list(place) for leg, *place in stones}


def parse_stone(text: str) -> Stone:
    """The stone that a line of text means: "LF,0.04,0.02". Raises `InputError`: none."""
    leg, *place = text.split(",")
    try:
        return _stone("stone", (leg.strip(), *map(float, place)))
    except ValueError:
        raise _refused("stone", text) from None


def _stone(name: str, row: Any) -> Stone:
    if isinstance(row, str | bytes) or not isinstance(row, Iterable):
        raise _refused(name, row)
    try:
        leg, *place = row
        numbers = [Number("").checked(name, each) for each in place]
        stone = Stone(Name("").checked(name, leg), *numbers)
    except (TypeError, ValueError, InputError):
        raise _refused(name, row) from None
    if max(map(abs, numbers)) > FARTHEST or stone.dz < 0:
        raise InputError(
            f"{name}: {stone.leg}: expected at most {FARTHEST:g} m, and none below the surface "
            f"that the feet land on, got {', '.join(f'{each:g}' for each in numbers)} m"
        )
    return stone


def _refused(name: str, value: Any) -> InputError:
    return InputError(f"{name}: expected {STONE} in m, got {reprlib.repr(value)}")
