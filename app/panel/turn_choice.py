"""Whole turns in the air as a menu: flips about the lateral axis, rolls about the long one."""

from __future__ import annotations

import math
from collections.abc import Collection

from llsrbm.request.jump import Jump

_TURNS: dict[str, tuple[str, float]] = {
    "back flip": ("pitch", -math.tau),
    "front flip": ("pitch", math.tau),
    "roll left": ("roll", -math.tau),
    "roll right": ("roll", math.tau),
}
"""Title -> field of `Jump` and rad, by the right-hand rule about x forward and y left."""


def turns_offered(asks: Collection[str], axes: Collection[str]) -> tuple[str, ...]:
    """Titles of the turns that a jump type asks for, about axes about which a robot makes them."""
    return tuple(title for title, (field, _) in _TURNS.items() if field in asks and field in axes)


def turn_title(jump: Jump) -> str:
    """The turn of a request; one that is not in the menu in degrees."""
    shown = {field: round(math.degrees(getattr(jump, field))) for field in ("pitch", "roll")}
    for title, (field, angle) in _TURNS.items():
        if shown == {"pitch": 0, "roll": 0, field: round(math.degrees(angle))}:
            return title
    return ", ".join(f"{field} {angle}°" for field, angle in shown.items() if angle) or "none"


def turn_amounts(title: str) -> dict[str, float]:
    """Fields of `Jump` that make a turn of the menu."""
    field, angle = _TURNS[title]
    return {"pitch": 0.0, "roll": 0.0, field: angle}
