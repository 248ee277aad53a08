"""Chosen charts at common instants, with shading and marks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from app.motion import colours
from app.motion.baked import PlannedMotion
from app.plots.charts import DASHED, SOLID, Chart, Layer, Line, charts
from app.plots.choice import PlotChoice
from llsrbm.arrays import Array
from llsrbm.motion.flights import flights

AXIS_STEP = 0.25
"""s. Time axes end at a multiple of it, or every plan of a dragged slider would stretch them."""

_BEFORE, _AFTER, _LANDING_STEP = 0.1, 0.25, 0.05  # s around touchdowns


@dataclass(frozen=True, eq=False)
class Figure:
    """Charts over the same P instants."""

    grid: TimeGrid  # the instants
    flight: Array  # (P,) high where the design that is shown plans to fly
    marks: tuple[Line, ...]  # upright lines: a step at each
    charts: tuple[Chart, ...]  # from top to bottom; their lines are sampled at the instants


def figure(choice: PlotChoice, layers: Sequence[Layer], end: float) -> Figure:
    """The chosen charts up to `end`, s; one layer at least is not pinned."""
    shown = [layer for layer in layers if not layer.pinned]
    planned = shown[0].motion
    assert isinstance(planned, PlannedMotion)  # what is not pinned has a plan
    plan = planned.plan
    flown = [tuple(plan.phase_start[[k, k + 1]].tolist()) for k in plan.schedule.flights]
    touchdowns = [
        _marks(shown, flight, landing, choice) for flight, (_, landing) in enumerate(flown)
    ]
    marks = [mark for each in touchdowns for mark in each]
    start, end = 0.0, math.ceil(end / AXIS_STEP - 1e-9) * AXIS_STEP
    if choice.landing:
        start, end = _around([instant for *_, instant in touchdowns[-1]])
    instants = [*(edge for flight in flown for edge in flight), *(at for *_, at in marks)]
    grid = TimeGrid.over(start, end, instants)
    return Figure(
        grid=grid,
        flight=np.maximum.reduce([grid.between(*flight) for flight in flown]),
        marks=tuple(
            Line(title, "", "", colour, dash, grid.time, grid.step(instant))
            for title, colour, dash, instant in marks
        ),
        charts=tuple(_sampled(chart, grid) for chart in charts(choice, layers)),
    )


def _sampled(chart: Chart, grid: TimeGrid) -> Chart:
    lines = (
        replace(
            line,
            time=grid.time,
            values=grid.sample(line.time, np.clip(line.values, -chart.most, chart.most)),
        )
        for line in chart.lines
    )
    return replace(chart, lines=tuple(lines))


_Mark = tuple[str, colours.Rgb, tuple[float, ...], float]  # title, colour, dash, instant (s)


def _marks(shown: Sequence[Layer], flight: int, planned: float, choice: PlotChoice) -> list[_Mark]:
    """The simulator's touchdown of a flight; in detail the planned one (s) and detection too."""
    marks: list[_Mark] = []
    if choice.landing:
        marks.append(("touchdown planned", shown[0].colour, SOLID, planned))
    for layer in shown:
        simulated = () if layer.rollout is None else flights(layer.rollout)[flight : flight + 1]
        for each in simulated:
            if each.touchdown is not None:
                marks.append(("touchdown", layer.colour, SOLID, each.touchdown))
            if choice.landing and each.detected is not None:
                marks.append(("detected", layer.colour, DASHED, each.detected))
    return marks


def _around(instants: Sequence[float]) -> tuple[float, float]:
    step = _LANDING_STEP
    start = math.floor((min(instants) - _BEFORE) / step) * step
    return max(start, 0.0), math.ceil((max(instants) + _AFTER) / step) * step


POINTS = 384  # Evenly spaced instants, in pairs: one to two pixels each in a chart of the area

ABOVE, BELOW = 2.0, -1.0
"""Values of steps, drawn on a scale from 0 to 1, so that only their upright part is in sight."""


@dataclass(frozen=True, eq=False)
class TimeGrid:
    """The few instants that a chart can show, to which curves are brought: uPlot wants one array.

    They are evenly spaced, and every instant at which something is marked is there twice, so that a
    step is drawn upright. A curve is interpolated there. Where it has a peak or a trough between
    the instants, as an impact of one control tick is, the two instants nearest to it show both its
    lowest and its highest value in the order of their appearance: no extremum is lost, and none
    moves by more than one and a half spacings.
    """

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
        """Spacing of the even instants, s."""
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
        return np.concatenate([thinned, marked, marked])[order]

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
