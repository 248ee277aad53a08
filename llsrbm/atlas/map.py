"""A map: a sweep's jumps over two of its axes, in cells, with the border of what can be done.

Of the axes that are not shown, a map is either of the slice that is nearest to a design (`NEAREST`:
each cell is the one jump whose other values are nearest to the design's) or of all that the sweep
has (`ALL`: each cell is its jumps together, see `llsrbm.atlas.colours`). Cells are the values of a
grid's axis; a drawn sweep's axis is divided evenly.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from llsrbm.arrays import Array, IntArray
from llsrbm.atlas.colours import COLOURS, Colour, of_share, of_stop
from llsrbm.atlas.jumps import Axis, Jumps
from llsrbm.look.palette import Rgb

NEAREST, ALL = "nearest", "all"
PROJECTIONS = (NEAREST, ALL)
"""What a map is of where a sweep varies more than its two axes."""

BORDER = 0.5
"""Share of plannable jumps on the border of what can be done."""

_MOST_CELLS = 60  # along an axis: a cell is some pixels wide
_LEAST = 1e-3  # of jumps that are as near to the design, the one in the middle of a cell
_A_CELL = 3  # jumps, of a drawn sweep, in a cell on average


@dataclass(frozen=True, eq=False)
class Scale:
    """An axis of a map, in cells."""

    axis: Axis  # which
    edges: Array  # (n+1,) of the cells, SI, increasing
    centres: Array  # (n,) a grid's values
    listed: bool  # whether cells are the values of a grid

    def cells(self, values: Array) -> IntArray:
        """(J,) numbers of the cells in which values lie."""
        return np.searchsorted(self.edges[1:-1], values, side="right")


@dataclass(frozen=True, eq=False)
class Map:
    """Jumps over two axes; arrays of (rows along y, columns along x)."""

    jumps: Jumps  # of which
    x: Scale  # axes
    y: Scale  # axes
    colour: Colour  # what is shown
    projection: str  # one of `PROJECTIONS`
    # Place in `jumps` of the jump that a cell opens, -1 where there is none.
    jump: IntArray
    count: IntArray  # jumps of a cell
    members: IntArray  # (K,) places in `jumps` of what is shown
    cell: IntArray  # (K,) in which of all cells

    def of(self, colour: Colour) -> Array:
        """(rows, columns) A colour's value of each cell, SI; NaN where no jump has one."""
        values = colour.of(self.jumps)[self.members]
        return colour.together(values, self.cell, self.jump.size).reshape(self.jump.shape)

    @cached_property
    def value(self) -> Array:
        """The shown value of each cell, SI; NaN where no jump has one."""
        return self.of(self.colour)

    @cached_property
    def border(self) -> tuple[Array, ...]:
        """(K, 2) SI, lines at which half of the jumps are plannable; empty cells are left out."""
        if min(self.jump.shape) < 2:
            return ()
        from contourpy import contour_generator

        # The outer cells go on to their outer edges.
        x, y = (np.r_[s.edges[0], s.centres, s.edges[-1]] for s in (self.x, self.y))
        share = np.ma.masked_invalid(np.pad(self.of(COLOURS["plannable"]), 1, mode="edge"))
        lines = contour_generator(x, y, share).lines(BORDER)
        return tuple(np.asarray(line, dtype=float) for line in lines)

    @property
    def ends(self) -> tuple[float, float]:
        """Ends of the colours' scale, SI."""
        if self.colour.ends is not None:
            return self.colour.ends
        known = self.value[np.isfinite(self.value)]
        return (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)

    def colour_of(self, value: float) -> Rgb | None:
        """The colour of a value, SI; None of NaN."""
        if math.isnan(value):
            return None
        if self.colour.categorical:
            return of_stop(int(value), self.jumps.stops)
        low, high = self.ends
        return of_share((value - low) / (high - low) if high > low else 1.0)

    @property
    def stops(self) -> tuple[int, ...]:
        """Limits in a map of what stops jumps, by place in `jumps.stops`; () for other maps."""
        if not self.colour.categorical:
            return ()
        return tuple(int(value) for value in np.unique(self.value[np.isfinite(self.value)]))


def map_of(
    jumps: Jumps,
    x: Axis,
    y: Axis,
    colour: Colour,
    *,
    projection: str = NEAREST,
    design: Mapping[str, float] | None = None,
) -> Map:
    """Lay jumps out over two axes.

    `design`: axis name -> SI value, of the slice and of the jumps that cells open; what it does not
    name has its default, or the median of the jumps' values.
    """
    scales = _scale(x, jumps.requested[x.name]), _scale(y, jumps.requested[y.name])
    across, up = (s.cells(jumps.requested[s.axis.name]) for s in scales)
    shape = len(scales[1].centres), len(scales[0].centres)
    away = _away(jumps, (x.name, y.name), design or {})
    away += _LEAST * _off_centre(jumps, scales, (across, up))
    cell = up * shape[1] + across
    order = np.lexsort((away, cell))  # cell by cell, the nearest of each first
    nearest = order[np.flatnonzero(np.diff(cell[order], prepend=-1))]
    jump = np.full(shape, -1, dtype=np.int64)
    jump.flat[cell[nearest]] = nearest
    count = np.bincount(cell, minlength=jump.size).reshape(shape)
    members = nearest if projection == NEAREST else np.arange(len(jumps))
    return Map(jumps, *scales, colour, projection, jump, count, members, cell[members])


def _scale(axis: Axis, values: Array) -> Scale:
    listed = np.unique(values)
    # Drawn values are all different; a grid has each of them with all of the other axes'.
    if len(listed) <= min(_MOST_CELLS, max(len(values) // 2, 2)):
        steps = np.diff(listed) / 2 if len(listed) > 1 else np.array([0.5])
        edges = np.r_[listed[0] - steps[0], listed[:-1] + steps[: len(listed) - 1], 0.0]
        edges[-1] = listed[-1] + steps[-1]
        return Scale(axis, edges, listed, listed=True)
    cells = min(max(round(math.sqrt(len(values) / _A_CELL)), 2), _MOST_CELLS)
    edges = np.linspace(values.min(), values.max(), cells + 1)
    return Scale(axis, edges, (edges[:-1] + edges[1:]) / 2, listed=False)


def _away(jumps: Jumps, shown: tuple[str, str], design: Mapping[str, float]) -> Array:
    """(J,) how far jumps are from a design in the axes that are not shown, in these' lengths."""
    away = np.zeros(len(jumps))
    for axis in jumps.axes:
        if axis.name not in shown:
            values = jumps.requested[axis.name]
            plain = float(np.median(values)) if axis.otherwise is None else axis.otherwise
            away += ((values - design.get(axis.name, plain)) / np.ptp(values)) ** 2
    return np.sqrt(away)


def _off_centre(
    jumps: Jumps, scales: tuple[Scale, Scale], cells: tuple[IntArray, IntArray]
) -> Array:
    """(J,) how far jumps are from the middle of their cell, in the axes' lengths."""
    parts = [
        (jumps.requested[scale.axis.name] - scale.centres[cell]) / np.ptp(scale.edges)
        for scale, cell in zip(scales, cells, strict=True)
    ]
    return np.hypot(*parts)
