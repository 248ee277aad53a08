"""Chosen charts at common instants, with shading and marks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from app.motion import colours
from app.motion.baked import PlannedMotion
from app.plots.charts import DASHED, SOLID, Chart, Layer, Line, charts
from app.plots.choice import PlotChoice
from app.plots.time_grid import TimeGrid
from llsrbm.mechanics import Array
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
        marks.append(("touch-down planned", shown[0].colour, SOLID, planned))
    for layer in shown:
        simulated = () if layer.rollout is None else flights(layer.rollout)[flight : flight + 1]
        for each in simulated:
            if each.touchdown is not None:
                marks.append(("touch-down", layer.colour, SOLID, each.touchdown))
            if choice.landing and each.detected is not None:
                marks.append(("detected", colours.FORCE, DASHED, each.detected))
    return marks


def _around(instants: Sequence[float]) -> tuple[float, float]:
    step = _LANDING_STEP
    start = math.floor((min(instants) - _BEFORE) / step) * step
    return max(start, 0.0), math.ceil((max(instants) + _AFTER) / step) * step
