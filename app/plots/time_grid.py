"""Curves at the few instants that a chart can show.

uPlot wants one array of times a chart, so all curves are brought to the same instants. These are
evenly spaced, and every instant at which something is marked is there twice, so that a step is
drawn upright. A curve is interpolated there. Where it has a peak or a trough between the instants,
as an impact of one control tick is, the two instants nearest to it show both its lowest and its
highest value in the order of their appearance: no extremum is lost, and none moves by more than
one and a half spacings.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from llsrbm.mechanics import Array

POINTS = 384  # Evenly spaced instants, in pairs: one to two pixels each in a chart of the area

ABOVE, BELOW = 2.0, -1.0
"""Values of steps, drawn on a scale from 0 to 1, so that only their upright part is in sight."""


@dataclass(frozen=True, eq=False)
class TimeGrid:
    """Instants that curves are brought to."""

    even: Array  # (POINTS,) s, evenly spaced
    marks: Array  # (M,) s
    time: Array  # (POINTS + 2 M,) s: all of them in order, marks twice

    @classmethod
    def over(cls, start: float, end: float, marks: Iterable[float] = ()) -> TimeGrid:
        """From `start` to `end`, s; marks outside of them are left out."""
        even = np.linspace(start, end, POINTS)
        inside = np.array(sorted(mark for mark in marks if start < mark < end), dtype=np.float64)
        return cls(even, inside, np.sort(np.concatenate([even, inside, inside])))

    @property
    def spacing(self) -> float:
        """Of the even instants, s."""
        return float(self.even[1] - self.even[0])

    def sample(self, time: Array, values: Array) -> Array:
        """A curve (K,) over `time` (K,) s at the instants, (P,); NaN where it has no value."""
        finite = np.isfinite(values)
        time, values = time[finite], values[finite]
        if not len(time):
            return np.full(len(self.time), np.nan)
        thinned = np.interp(self.even, time, values)
        slack = self.spacing / 2
        thinned[(self.even < time[0] - slack) | (self.even > time[-1] + slack)] = np.nan
        self._restore_extrema(thinned, time, values)
        # On the straight line between its neighbours, an instant more changes nothing.
        marked = np.interp(self.marks, self.even, thinned)
        order = np.argsort(np.concatenate([self.even, self.marks, self.marks]), kind="stable")
        sampled: Array = np.concatenate([thinned, marked, marked])[order]
        return sampled

    def step(self, instant: float) -> Array:
        """Rises at an instant, (P,); upright where it is marked, else within a spacing."""
        first = np.searchsorted(self.time, instant, side="left")
        return np.where(np.arange(len(self.time)) > first, ABOVE, BELOW)

    def between(self, start: float, end: float) -> Array:
        """High between two instants, s, and low elsewhere, (P,)."""
        high = (self.step(start) > 0) & (self.step(end) < 0)
        return np.where(high, ABOVE, BELOW)

    def _restore_extrema(self, thinned: Array, time: Array, values: Array) -> None:
        """Have each pair of instants show what lies around it and would not be seen."""
        pair = np.floor((time - self.even[0]) / self.spacing + 0.5).astype(int) // 2
        known = (pair >= 0) & (pair < POINTS // 2)
        pair, values = pair[known], values[known]
        if not len(pair):
            return
        pairs, first = np.unique(pair, return_index=True)
        high, low = np.maximum.reduceat(values, first), np.minimum.reduceat(values, first)
        # A slope needs no help: what a neighbour shows as well is no extremum.
        near = np.pad(thinned, 1, mode="edge")[2 * pairs[:, None] + np.arange(4)]
        seen = (high <= np.fmax.reduce(near, axis=1)) & (low >= np.fmin.reduce(near, axis=1))
        counts = np.diff(np.append(first, len(values)))
        where = np.arange(len(values))
        top, bottom = (
            np.minimum.reduceat(
                np.where(values == np.repeat(extreme, counts), where, len(values)), first
            )
            for extreme in (high, low)
        )
        thinned[2 * pairs[~seen]] = np.where(top < bottom, high, low)[~seen]
        thinned[2 * pairs[~seen] + 1] = np.where(top < bottom, low, high)[~seen]
