"""Colours of a map: each with name, unit, and its value of several jumps.

A jump's seeds are together already (`llsrbm.atlas.jumps`): shares are of its seeds. A cell of
several jumps has the mean of their shares and figures, and the limiting constraint of most of them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array, IntArray
from llsrbm.atlas.jumps import Jumps
from llsrbm.look.palette import Rgb

SCALE: tuple[Rgb, ...] = (
    (250, 241, 205),
    (170, 214, 184),
    (76, 166, 178),
    (42, 104, 156),
    (36, 48, 104),
)
"""From the lowest to the highest value: lightness falls evenly, so that grey shows it, too."""

CATEGORIES: tuple[Rgb, ...] = (
    (230, 159, 0),
    (86, 180, 233),
    (0, 158, 115),
    (213, 94, 0),
    (204, 121, 167),
    (0, 114, 178),
    (140, 110, 70),
)
"""Of limiting constraints, most frequent first; the rest is `REST`. Okabe and Ito's, which
colour-blind eyes distinguish."""

REST: Rgb = (130, 130, 130)
FREE: Rgb = (215, 226, 216)
"""Of feasible jumps."""


@dataclass(frozen=True)
class Colour:
    """A quantity that a map may show."""

    name: str  # in commands
    title: str  # for people
    unit: str  # of what they are shown, "" if there is none
    of: Callable[[Jumps], Array]  # jumps -> (J,) SI; NaN of a jump that has none
    scale: float = 1.0  # shown units per SI unit
    ends: tuple[float, float] | None = None  # of its scale, SI; None where the values have them
    categorical: bool = False  # values are places in `Jumps.stops`

    @property
    def heading(self) -> str:
        """Title and unit."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title

    def together(self, values: Array, cell: IntArray, cells: int) -> Array:
        """(C,) one value a cell, of its jumps that have one; NaN where none has.

        The mean, or the most frequent of categories. `values`: (K,) of jumps; cell: (K,) in which
        they are; cells: how many there are.
        """
        if self.categorical:
            stops = int(values.max(initial=0)) + 1
            counts = np.bincount(cell * stops + values.astype(np.int64), minlength=cells * stops)
            table = counts.reshape(cells, stops)
            return np.where(table.any(axis=1), table.argmax(axis=1), np.nan)
        known = np.isfinite(values)
        count = np.bincount(cell[known], minlength=cells)
        total = np.bincount(cell[known], values[known], minlength=cells)
        return np.where(count > 0, total / np.maximum(count, 1), np.nan)


_SHARE: tuple[float, tuple[float, float]] = 100.0, (0.0, 1.0)  # shown in per cent
COLOURS: Mapping[str, Colour] = {
    colour.name: colour
    for colour in (
        Colour("plannable", "Can be planned", "%", lambda jumps: jumps.planned, *_SHARE),
        Colour(
            *("strict", "Strict share", "%"),
            lambda jumps: np.where(jumps.planned > 0, jumps.strict, np.nan),
            *_SHARE,
        ),
        Colour("torque", "Largest torque share", "%", lambda jumps: jumps.torque_share, 100.0),
        Colour("flight", "Flight time", "s", lambda jumps: jumps.flight),
        Colour(
            *("stopped-by", "Limiting constraint", ""),
            lambda jumps: jumps.stop.astype(float),
            categorical=True,
        ),
    )
}
"""By name."""


def of_share(share: float) -> Rgb:
    """The colour at a share, 0 to 1, of the scale."""
    places = np.linspace(0.0, 1.0, len(SCALE))
    red, green, blue = (round(np.interp(share, places, part)) for part in zip(*SCALE))
    return red, green, blue


def of_stop(place: int, stops: tuple[str, ...]) -> Rgb:
    """The colour of the constraint at a place in `stops`, where "", none, may come first."""
    if stops[place] == "":
        return FREE
    rank = place - (stops[0] == "")
    return CATEGORIES[rank] if rank < len(CATEGORIES) else REST
