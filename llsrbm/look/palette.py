"""One colour a thing, the same in every picture, plot, timeline and legend."""

from __future__ import annotations

Rgb = tuple[int, int, int]

PLANNED: Rgb = (44, 123, 229)
SIMULATED: Rgb = (222, 96, 16)
RIGID: Rgb = (240, 140, 30)
FORCE: Rgb = (214, 51, 108)
COM: Rgb = (90, 60, 180)
FOOT: Rgb = (110, 120, 130)
PUSH: Rgb = (176, 0, 150)
REPLANNED: Rgb = (118, 168, 0)
TARGET: Rgb = (40, 160, 90)
BLOCK: Rgb = (172, 132, 84)
INFEASIBLE: Rgb = (220, 40, 40)

TAKE_OFF: Rgb = (227, 169, 59)
FLIGHT: Rgb = (76, 143, 220)
LANDING: Rgb = (87, 167, 115)
REBOUND: Rgb = (157, 168, 87)  # between two flights: a landing and a take-off at once
PHASES: tuple[Rgb, ...] = (TAKE_OFF, FLIGHT, LANDING)
STANDING: Rgb = (206, 211, 217)
GROUND: Rgb = (206, 211, 217)


def paler(colour: Rgb, share: float) -> Rgb:
    """A colour that far on its way to white, 0 to 1."""
    red, green, blue = (round(part + share * (255 - part)) for part in colour)
    return red, green, blue


def css(colour: Rgb, opacity: float = 1.0) -> str:
    """As style sheets write it."""
    return f"rgba({colour[0]},{colour[1]},{colour[2]},{opacity:g})"
