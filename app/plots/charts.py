"""The charts of chosen signals: the lines drawn in each, of every motion that is shown."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property

import numpy as np

from app.motion import colours
from app.motion.baked import ForeignMotion, PlannedMotion
from app.motion.colours import Rgb
from app.plots.choice import ALL, ALL_JOINTS, EACH, ChartChoice, PlotChoice
from app.plots.signals import SIGNALS, Samples, Signal
from app.plots.time_series import TimeSeries
from llsrbm.arrays import Array
from llsrbm.motion.rollout import Rollout

LIMIT: Rgb = colours.REFERENCE

SOLID: tuple[float, ...] = ()
DASHED = (4.0, 4.0)  # Pixels drawn and left out, of limits, of second curves, of detections

# Lines by the motion: solid is what is drawn solid in the picture.
_PLAN_DASH = (8.0, 3.0)  # of a plan that is a ghost beside its simulation
_PINNED_DASHES = ((2.0, 2.5), (9.0, 3.0, 2.0, 3.0), (6.0, 2.0, 2.0, 2.0, 2.0, 2.0))

_PALER = 0.45  # of the way to white, of components that have no colour of their own any more


Look = tuple[str, Rgb, tuple[float, ...]]  # name, colour, dashes


@dataclass(frozen=True, eq=False)
class Layer:
    """A motion to be plotted: one line in each chart."""

    title: str  # its name in the legend
    colour: Rgb  # of its lines
    motion: PlannedMotion | ForeignMotion  # a plan, or a motion from a file
    rollout: Rollout | None  # plotted instead of the plan, if there is one
    pinned: bool  # it is there for comparison: marks and time axis are the others'
    dash: tuple[float, ...] = SOLID  # of its lines

    @cached_property
    def series(self) -> TimeSeries:
        """Its plotted quantities; costs some milliseconds once."""
        plan = self.motion if isinstance(self.motion, PlannedMotion) else None
        if self.rollout is not None:
            return TimeSeries.of_rollout(self.rollout, plan.motion if plan else None)
        if plan is not None:
            return TimeSeries.of_plan(plan.plan, plan.motion)
        return TimeSeries.of_motion(self.motion.motion)

    def is_same_as(self, other: Layer) -> bool:
        """True if both draw the same lines."""
        return (
            self.motion is other.motion
            and self.rollout is other.rollout
            and (self.title, self.colour, self.pinned) == (other.title, other.colour, other.pinned)
            and self.dash == other.dash
        )


def shown_layers(planned: PlannedMotion, rollout: Rollout | None) -> tuple[Layer, ...]:
    """The design that is shown: its plan and, if there is one, its simulation."""
    dash = SOLID if rollout is None else _PLAN_DASH
    plan = Layer("plan", colours.PLANNED, planned, None, pinned=False, dash=dash)
    if rollout is None:
        return (plan,)
    return (plan, Layer("simulation", colours.SIMULATED, planned, rollout, pinned=False))


def pinned_layer(
    title: str, colour: Rgb, motion: PlannedMotion | ForeignMotion, rollout: Rollout | None
) -> Layer:
    """A pinned design; `colour` is one of `colours.PINNED`, each of which has its own dashes."""
    dash = _PINNED_DASHES[colours.PINNED.index(colour)]
    return Layer(title, colour, motion, rollout, pinned=True, dash=dash)


def contending_layers(
    name: str, colour: Rgb, planned: PlannedMotion, rollout: Rollout, *, pinned: bool
) -> tuple[Layer, ...]:
    """One of several ways to make a jump: its plan and its simulation, in its colour."""
    plan = Layer(f"{name}, plan", colour, planned, None, pinned=pinned, dash=_PLAN_DASH)
    return (plan, Layer(name, colour, planned, rollout, pinned=pinned))


class Role(Enum):
    """Meaning of a line of a chart."""

    MOTION = "motion"  # a quantity of the motion
    SECOND = "second"  # the same quantity by another model
    LIMIT = "limit"  # a limit or a threshold, of no motion


@dataclass(frozen=True, eq=False)
class Line:
    """One curve of a chart."""

    title: str  # the layer's, or that of a limit or mark
    component: str  # of several that share the chart; ""
    unit: str  # of the values
    colour: Rgb  # of the component, if several share the chart, else of the motion
    dash: tuple[float, ...]  # of the motion: pixels drawn and left out, in turn
    time: Array  # (K,) s, increasing
    values: Array  # (K,)
    role: Role = Role.MOTION

    @property
    def name(self) -> str:
        """Title and component."""
        return f"{self.title} {self.component}".rstrip()

    @property
    def look(self) -> Look:
        """Name, colour and dashes."""
        return self.name, self.colour, self.dash


@dataclass(frozen=True, eq=False)
class Chart:
    """One quantity, or one component of it, of all layers that have it."""

    source: ChartChoice  # that asks for this one chart
    title: str  # quantity and component
    unit: str  # of its axis
    lines: tuple[Line, ...]  # drawn in this order
    least: float = 0.0  # least, most: as in `Signal`
    most: float = np.inf

    @property
    def heading(self) -> str:
        """Title and unit."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title


def charts(choice: PlotChoice, layers: Sequence[Layer]) -> tuple[Chart, ...]:
    """All chosen charts of signals that some layer has."""
    return tuple(
        chart
        for chosen in choice.charts
        if chosen.signal in SIGNALS
        for chart in _charts(chosen, layers)
    )


def everything() -> PlotChoice:
    """Every chart that there is: all that can be drawn of a motion."""
    return PlotChoice(tuple(ChartChoice(key, each=True) for key in SIGNALS))


def name_of(chosen: ChartChoice) -> str:
    """A chart in menus."""
    return " · ".join(
        ", ".join([SIGNALS[part.signal].title, *part.components, *([EACH] if part.each else [])])
        for part in chosen.parts
    )


def components_offered(key: str, layers: Sequence[Layer]) -> tuple[str, ...]:
    """Choices of a signal's components, of the first layer that has it: all, each, sets, single."""
    sampled = (SIGNALS[key].of(layer.series) for layer in layers)
    components = next((s.components for s in sampled if s is not None), ())
    if len(components) <= 1:
        return (ALL,)
    tags = dict.fromkeys(tag for component in components for tag in component.tags)
    names = dict.fromkeys(component.name for component in components)
    return tuple(dict.fromkeys((ALL, EACH, *tags, *names)))


_Sampled = Sequence[tuple[Layer, Samples]]


def _charts(chosen: ChartChoice, layers: Sequence[Layer]) -> Iterator[Chart]:
    if not chosen.more:
        yield from _charts_of_signal(chosen, layers)
        return
    parts = [chart for part in chosen.parts for chart in _charts_of_signal(part, layers)]
    if parts:
        yield _together(chosen, parts)


def _together(chosen: ChartChoice, parts: Sequence[Chart]) -> Chart:
    """One chart of several signals, each of which is a component."""
    found: dict[str, Rgb] = {}
    lines: list[Line] = []
    for part in parts:
        for line in part.lines:
            if line.role is Role.LIMIT:
                lines.append(line)
                continue
            name = f"{part.title} {line.component}".rstrip()
            colour = found.setdefault(name, component_colour(len(found)))
            lines.append(replace(line, component=name, colour=colour))
    return Chart(
        chosen,
        " · ".join(dict.fromkeys(part.title for part in parts)),
        " or ".join(dict.fromkeys(part.unit for part in parts if part.unit)),
        tuple(lines),
        max(part.least for part in parts),
        max(part.most for part in parts),
    )


def _charts_of_signal(chosen: ChartChoice, layers: Sequence[Layer]) -> Iterator[Chart]:
    signal = SIGNALS[chosen.signal]
    sampled = [
        (layer, samples) for layer in layers if (samples := signal.of(layer.series)) is not None
    ]
    names = dict.fromkeys(
        component.name
        for _, samples in sampled
        for component in samples.components
        if component.is_one_of(chosen.components)
    )
    if chosen.each:
        for name in names:
            yield _chart(ChartChoice(signal.key, (name,)), sampled, (name,))
    elif names:
        yield _chart(chosen, sampled, tuple(names), ", ".join(chosen.components))


def _chart(source: ChartChoice, sampled: _Sampled, names: tuple[str, ...], of: str = "") -> Chart:
    """One chart of the components with these names; `of` is the name of their set."""
    signal = SIGNALS[source.signal]
    only = names[0] if len(names) == 1 else of
    lines: list[Line] = []
    for layer, samples in sampled:
        lines += _lines(layer, samples, names, layer.title)
    for layer, _ in sampled:
        if signal.also is not None and layer.rollout is None and not layer.pinned:
            second = _lines(layer, signal.also(layer.series), names, signal.also_title)
            lines += [replace(line, dash=DASHED, role=Role.SECOND) for line in second]
    level = _level(signal, sampled, lines)
    units = dict.fromkeys(line.unit for line in lines if line.unit)
    title = f"{signal.title}, {only}" if only and only != ALL_JOINTS else signal.title
    return Chart(source, title, " or ".join(units), (*level, *lines), signal.least, signal.most)


def _lines(layer: Layer, samples: Samples, names: tuple[str, ...], title: str) -> Iterator[Line]:
    columns = {component.name: k for k, component in enumerate(samples.components)}
    for name in names:
        if name not in columns:
            continue  # a robot with other joints
        yield Line(
            title,
            name if len(names) > 1 else "",
            samples.components[columns[name]].unit,
            component_colour(columns[name]) if len(names) > 1 else layer.colour,
            layer.dash,
            samples.time,
            samples.values[:, columns[name]],
        )


def component_colour(index: int) -> Rgb:
    """Colour of a component that shares a chart, by its place among all of its signal."""
    turn, place = divmod(index, len(colours.COMPONENTS))
    return colours.paler(colours.COMPONENTS[place], _PALER * (turn % 2))


def _level(signal: Signal, sampled: _Sampled, lines: Sequence[Line]) -> list[Line]:
    """A dashed line across the chart, if there is a limit; the last layer's, which is on top."""
    if signal.level is None or not lines:
        return []
    known = [value for layer, _ in sampled if (value := signal.level(layer.series)) is not None]
    if not known:
        return []
    ends = np.array([[line.time[0], line.time[-1]] for line in lines])
    across = np.array([ends[:, 0].min(), ends[:, 1].max()])
    values = np.full(2, known[-1])
    return [Line(signal.level_title, "", "", LIMIT, DASHED, across, values, Role.LIMIT)]


def csv_of(layers: Sequence[Layer], choice: PlotChoice) -> bytes:
    """All lines of the chosen charts, UTF-8; the whole motions, whatever part an axis shows.

    Nothing is resampled: lines with the same instants share a time column to their left. Where a
    line has no value, or is shorter than others, the cell is empty. The first row names the
    columns: "time of plan [s]", "CoM position, x, plan [m]".
    """
    blocks: list[tuple[Array, list[tuple[str, Line]]]] = []
    for chart in charts(choice, layers):
        for line in chart.lines:
            block = next((lines for time, lines in blocks if np.array_equal(time, line.time)), None)
            if block is None:
                block = []
                blocks.append((line.time, block))
            block.append((chart.title, line))
    columns: list[list[str]] = []
    for time, lines in blocks:
        titles = ", ".join(dict.fromkeys(line.title for _, line in lines))
        columns.append([f"time of {titles} [s]", *_cells(time)])
        for title, line in lines:
            unit = f" [{line.unit}]" if line.unit else ""
            columns.append([f"{title}, {line.name}{unit}", *_cells(line.values)])
    length = max(map(len, columns), default=0)
    text = io.StringIO()
    rows = zip(*(column + [""] * (length - len(column)) for column in columns), strict=True)
    csv.writer(text).writerows(rows)
    return text.getvalue().encode("utf-8")


def _cells(values: Array) -> list[str]:
    # Adding 0 takes the sign off a zero.
    return [f"{value + 0.0:.9g}" if np.isfinite(value) else "" for value in values]
