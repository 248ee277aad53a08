"""The page's colours: those of the library, and what only the page draws."""

from llsrbm.look.palette import *  # noqa: F403
from llsrbm.look.palette import FORCE, Rgb, paler

PINNED: tuple[Rgb, ...] = ((128, 32, 240), (176, 80, 96), (176, 160, 96))
"""Of pinned designs: with plan and simulation at least 20 apart in CIELAB, for colour-blind eyes
too, and 2.5 : 1 against white and against viser's dark panel."""

COMPONENTS: tuple[Rgb, ...] = (
    (0, 144, 128),
    (208, 144, 0),
    (132, 88, 212),
    (112, 144, 16),
    (160, 92, 56),
    (224, 96, 144),
)
"""Of components that share a chart, where motions differ by line style: none is near the blue of
plans or the orange of simulations."""

FRICTION: Rgb = paler(FORCE, 0.4)  # bounds of forces
SUPPORT: Rgb = (22, 150, 160)
REACH: Rgb = paler(SUPPORT, 0.3)  # where feet may be
COLLISION: Rgb = (206, 172, 32)


def linear(colour: Rgb) -> list[float]:
    """A colour as glTF has it: proportional to light, not to what an eye sees."""
    return [(c / 255) ** 2.2 for c in colour]
