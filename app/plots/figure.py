"""Chosen charts as numbers: common instants, shading, marks, and a row of values a line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.motion import colours
from app.motion.colours import Rgb
from app.plots.charts import DASHED, SOLID, Chart, Layer, charts
from app.plots.choice import ChartChoice, PlotChoice
from app.plots.signals import SIGNALS
from app.plots.time_grid import TimeGrid
from llsrbm.motion.flights import flights

Array = NDArray[np.float64]

AXIS_STEP = 0.25
"""s. Time axes end at a multiple of it, or every plan of a dragged slider would stretch them."""

_BEFORE, _AFTER, _LANDING_STEP = 0.1, 0.25, 0.05  # s around touchdowns


@dataclass(frozen=True)
class Stroke:
    """How a line is drawn and its name.

    Attributes:
        title: a layer's, a mark's.
        colour: of the line; dash: pixels drawn and left out, in turn.
        component: of several that share a chart.
    """

    title: str
    colour: Rgb
    dash: tuple[float, ...] = SOLID
    component: str = ""

    @property
    def name(self) -> str:
        """Title and component."""
        return f"{self.title} {self.component}".rstrip()


@dataclass(frozen=True, eq=False)
class Rows:
    """The lines of a chart.

    Attributes:
        title: quantity and unit.
        strokes: of the lines.
        values: (P,) of each line.
        least: as in `app.plots.signal.Signal`.
    """

    title: str
    strokes: tuple[Stroke, ...]
    values: tuple[Array, ...]
    least: float


@dataclass(frozen=True, eq=False)
class Figure:
    """Charts over the same P instants.

    Attributes:
        grid: the instants.
        flight: (P,) high where the design that is shown plans to fly.
        mark_strokes: of upright lines; marks: (P,) a step at each.
        charts: from top to bottom.
    """

    grid: TimeGrid
    flight: Array
    mark_strokes: tuple[Stroke, ...]
    marks: tuple[Array, ...]
    charts: tuple[Rows, ...]


def figure(choice: PlotChoice, layers: Sequence[Layer], end: float) -> Figure:
    """The chosen charts.

    Args:
        choice: of charts.
        layers: what to draw, the first ones below; one of them at least is not pinned.
        end: of the motion that is shown, s.
    """
    shown = [layer for layer in layers if not layer.pinned]
    replay = shown[0].replay
    assert replay is not None  # what is not pinned has a plan
    plan = replay.plan
    flown = [tuple(plan.phase_start[[k, k + 1]].tolist()) for k in plan.schedule.flights]
    touchdowns = [
        _marks(shown, flight, planned, choice) for flight, (_, planned) in enumerate(flown)
    ]
    marks = [mark for each in touchdowns for mark in each]
    if choice.landing:
        start, end = _around([instant for _, instant in touchdowns[-1]])
    else:
        start, end = 0.0, math.ceil(end / AXIS_STEP - 1e-9) * AXIS_STEP
    instants = [*(edge for flight in flown for edge in flight), *(at for _, at in marks)]
    grid = TimeGrid.over(start, end, instants)
    return Figure(
        grid=grid,
        flight=np.maximum.reduce([grid.between(*flight) for flight in flown]),
        mark_strokes=tuple(stroke for stroke, _ in marks),
        marks=tuple(grid.step(instant) for _, instant in marks),
        charts=tuple(_rows(chart, grid) for chart in charts(choice, layers)),
    )


def everything() -> PlotChoice:
    """Every chart that there is: what can be drawn of a motion at all."""
    return PlotChoice(tuple(ChartChoice(key, each=True) for key in SIGNALS))


def _rows(chart: Chart, grid: TimeGrid) -> Rows:
    lines = chart.lines
    return Rows(
        chart.heading,
        tuple(Stroke(line.title, line.colour, line.dash, line.component) for line in lines),
        tuple(
            grid.sample(line.time, np.clip(line.values, -chart.most, chart.most)) for line in lines
        ),
        chart.least,
    )


def _marks(
    shown: Sequence[Layer], flight: int, planned: float, choice: PlotChoice
) -> list[tuple[Stroke, float]]:
    """A flight's touchdown: the simulator's; in detail the planned one and its detection as well.

    Args:
        shown: plan and simulation.
        flight: its number, from 0 on.
        planned: when it shall end, s.
        choice: of charts.
    """
    detailed = choice.landing
    marks = [(Stroke("touch-down planned", shown[0].colour), planned)] if detailed else []
    for layer in shown:
        simulated = () if layer.rollout is None else flights(layer.rollout)[flight : flight + 1]
        for each in simulated:
            if each.touchdown is not None:
                marks.append((Stroke("touch-down", layer.colour), each.touchdown))
            if detailed and each.detected is not None:
                marks.append((Stroke("detected", colours.FORCE, DASHED), each.detected))
    return marks


def _around(instants: Sequence[float]) -> tuple[float, float]:
    """Start and end of a time axis that shows these closely, s."""
    step = _LANDING_STEP
    start = math.floor((min(instants) - _BEFORE) / step) * step
    return max(start, 0.0), math.ceil((max(instants) + _AFTER) / step) * step
