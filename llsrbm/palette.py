"""One colour a thing, the same in every picture, plot, timeline and legend."""

from __future__ import annotations

Rgb = tuple[int, int, int]

PLANNED: Rgb = (44, 123, 229)
SIMULATED: Rgb = (222, 96, 16)
RIGID: Rgb = (240, 140, 30)
FORCE: Rgb = (214, 51, 108)
COM: Rgb = (90, 60, 180)
FOOT: Rgb = (110, 120, 130)
TARGET: Rgb = (40, 160, 90)
BLOCK: Rgb = (172, 132, 84)
INFEASIBLE: Rgb = (220, 40, 40)

PHASES: tuple[Rgb, ...] = ((227, 169, 59), (76, 143, 220), (87, 167, 115))
STANDING: Rgb = (206, 211, 217)
GROUND: Rgb = (206, 211, 217)


def css(colour: Rgb, opacity: float = 1.0) -> str:
    """As style sheets write it."""
    return f"rgba({colour[0]},{colour[1]},{colour[2]},{opacity:g})"
