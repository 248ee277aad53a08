"""The page's colours: those of the library, and what only the page draws."""

from __future__ import annotations

from llsrbm.look.palette import *  # noqa: F403
from llsrbm.look.palette import Rgb

PINNED: tuple[Rgb, ...] = ((140, 40, 255), (112, 112, 60), (214, 118, 168))
"""Of pinned designs: with the two above at least 20 apart in CIELAB, for colour-blind eyes too, and
2.5 : 1 against white and against viser's dark panel."""

FRICTION: Rgb = (232, 150, 60)
SUPPORT: Rgb = (22, 150, 160)
REACH: Rgb = (70, 150, 200)
COLLISION: Rgb = (200, 90, 150)

CURSOR: Rgb = (34, 34, 34)
DETECTION: Rgb = (255, 255, 255)


def linear(colour: Rgb) -> list[float]:
    """A colour as glTF has it: proportional to light, not to what an eye sees."""
    return [(c / 255) ** 2.2 for c in colour]
