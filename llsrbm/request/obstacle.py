"""A hurdle to jump over, or a gap in the ground, between start and landing.

It runs across the heading at the start, along the world's y axis, as far as anybody looks.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from llsrbm.errors import InputError, printable

HIGHEST = 1.0  # m, of a hurdle; robots jump half of that
DEEPEST = 2.0  # m, of a gap
LEAST = 0.01  # m, width, height or depth: what is smaller is no obstacle
FURTHEST = 100.0  # m from the start
WIDEST = 2.0  # m, from near to far edge


@dataclass(frozen=True)
class Obstacle:
    """A hurdle or a gap in the world. Raises `InputError`: numbers that cannot be."""

    near: float  # m, where it begins and ends along the world's x axis
    far: float  # m, where it begins and ends along the world's x axis
    height: float  # m above the ground at the start, of a hurdle; below zero: a gap, so deep

    def __post_init__(self) -> None:
        why = wrong_shape(self.near, self.far, self.height)
        if why:
            raise InputError(f"obstacle: {why}")

    @property
    def is_gap(self) -> bool:
        """True if the ground lies lower there."""
        return self.height < 0

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for files."""
        return asdict(self)

    @classmethod
    def from_dict(cls, table: dict[str, Any]) -> Obstacle:
        """The obstacle that `as_dict` wrote, checked. Raises `InputError`: it is no obstacle."""
        try:
            return cls(*(float(table[name]) for name in ("near", "far", "height")))
        except (LookupError, TypeError, ValueError, OverflowError) as error:
            raise InputError(
                f"obstacle: not one that this version wrote ({printable(repr(error))}); expected "
                "near, far and height, m"
            ) from error


def wrong_shape(near: float, far: float, height: float) -> str:
    """The fault of an obstacle of these measures, m, and what is accepted; "" if none."""
    if not all(map(math.isfinite, (near, far, height))):
        return f"from {near:g} to {far:g} m, height {height:g} m; expected finite numbers"
    if abs(near) > FURTHEST:
        return f"it begins at {near:g} m; expected -{FURTHEST:g} to {FURTHEST:g} m"
    if not LEAST <= far - near <= WIDEST:
        return (
            f"it goes from {near:g} to {far:g} m; expected an end that is {LEAST:g} to "
            f"{WIDEST:g} m beyond the beginning"
        )
    if not (LEAST <= height <= HIGHEST or LEAST <= -height <= DEEPEST):
        return (
            f"height {height:g} m; expected a hurdle of {LEAST:g} to {HIGHEST:g} m, or a gap of "
            f"-{LEAST:g} to -{DEEPEST:g} m"
        )
    return ""
