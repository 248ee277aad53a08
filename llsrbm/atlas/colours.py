"""Colours of a map: each a small class with name, unit, and its value of several jumps.

A jump's seeds are together already (`llsrbm.atlas.jumps`): shares are of its seeds. A cell of
several jumps has the mean of their shares and figures, and the limiting constraint of most of them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from llsrbm.atlas.jumps import Jumps
from llsrbm.look.palette import Rgb

Array = NDArray[np.float64]

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


class Colour(ABC):
    """A quantity that a map may show.

    Attributes:
        name: in commands; title: for people; unit: of what they are shown, "" if there is none.
        scale: shown units per SI unit.
        ends: of its scale, SI; None where the values have them.
        categorical: values are places in `Jumps.stops`.
    """

    name: str
    title: str
    unit: str = ""
    scale: float = 1.0
    ends: tuple[float, float] | None = None
    categorical: bool = False

    @property
    def heading(self) -> str:
        """Title and unit."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title

    @abstractmethod
    def of(self, jumps: Jumps) -> Array:
        """(J,) SI; NaN of a jump that has none."""

    def together(self, values: Array, cell: NDArray[np.int64], cells: int) -> Array:
        """(C,) one value a cell, of its jumps that have one; NaN where none has.

        Args:
            values: (K,) of jumps; cell: (K,) in which they are; cells: how many there are.
        """
        known = np.isfinite(values)
        count = np.bincount(cell[known], minlength=cells)
        total = np.bincount(cell[known], values[known], minlength=cells)
        return np.where(count > 0, total / np.maximum(count, 1), np.nan)


class Plannable(Colour):
    """Share of jumps with a plan."""

    name, title, unit, scale, ends = "plannable", "Plannable", "%", 100.0, (0.0, 1.0)

    def of(self, jumps: Jumps) -> Array:  # noqa: D102
        return jumps.planned


class Strict(Colour):
    """Share of simulated jumps that landed by the strict measure; not of those without a plan."""

    name, title, unit, scale, ends = "strict", "Strict share", "%", 100.0, (0.0, 1.0)

    def of(self, jumps: Jumps) -> Array:  # noqa: D102
        return np.where(jumps.planned > 0, jumps.strict, np.nan)


class TorqueShare(Colour):
    """Largest share of the torque that is available at a joint's speed, of plans."""

    name, title, unit, scale = "torque", "Largest torque share", "%", 100.0

    def of(self, jumps: Jumps) -> Array:  # noqa: D102
        return jumps.torque_share


class FlightTime(Colour):
    """Time without a foot on the ground, of plans."""

    name, title, unit = "flight", "Flight time", "s"

    def of(self, jumps: Jumps) -> Array:  # noqa: D102
        return jumps.flight


class StoppedBy(Colour):
    """Limiting constraint of a jump; of several, that of most of them."""

    name, title, categorical = "stopped-by", "What stops it", True

    def of(self, jumps: Jumps) -> Array:  # noqa: D102
        return jumps.stop.astype(float)

    def together(self, values: Array, cell: NDArray[np.int64], cells: int) -> Array:  # noqa: D102
        stops = int(values.max(initial=0)) + 1
        counts = np.bincount(cell * stops + values.astype(np.int64), minlength=cells * stops)
        table = counts.reshape(cells, stops)
        return np.where(table.any(axis=1), table.argmax(axis=1), np.nan)


COLOURS: Mapping[str, Colour] = {
    colour.name: colour
    for colour in (Plannable(), Strict(), TorqueShare(), FlightTime(), StoppedBy())
}
"""By name."""


def of_share(share: float) -> Rgb:
    """The colour at a share, 0 to 1, of the scale."""
    place = min(max(share, 0.0), 1.0) * (len(SCALE) - 1)
    lower = min(int(place), len(SCALE) - 2)
    mixed = [
        round(low + (place - lower) * (high - low))
        for low, high in zip(SCALE[lower], SCALE[lower + 1], strict=True)
    ]
    return mixed[0], mixed[1], mixed[2]


def of_stop(place: int, stops: tuple[str, ...]) -> Rgb:
    """The colour of a limiting constraint.

    Args:
        place: in `stops`, of which "", none, comes first if it is there.
    """
    if stops[place] == "":
        return FREE
    rank = place - (stops[0] == "")
    return CATEGORIES[rank] if rank < len(CATEGORIES) else REST
