"""The charts that a tab shows, a pure value that is part of its state; and the presets."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from llsrbm.request.jump import Jump

ALL_JOINTS = "all joints"
ALL = "all"
EACH = "a chart each"

OVERVIEW, TORQUES, LANDING = "Overview", "Joint torques and speeds", "Landing"
FEW = "Two charts"  # Of a small page
OWN = "Custom"  # Name of charts that are no preset

MOST_SIGNALS = 4  # in one chart
MOST_CHARTS = 12  # Choices of charts in one tab; each may be as many charts as a robot has joints


@dataclass(frozen=True)
class ChartChoice:
    """A chart, or several."""

    signal: str  # key of one of `app.plots.signals.SIGNALS`
    # names or tags of its components that are drawn, such as "z", "LF", "KFE"; none: all of them
    components: tuple[str, ...] = ()
    each: bool = False  # each component has a chart of its own
    more: tuple[ChartChoice, ...] = ()  # signals that are drawn in the same chart

    @property
    def parts(self) -> tuple[ChartChoice, ...]:
        """Every signal of the chart."""
        return (replace(self, more=()), *self.more)


@dataclass(frozen=True)
class PlotChoice:
    """The charts that are plotted."""

    charts: tuple[ChartChoice, ...]  # in their order, no two alike
    landing: bool = False  # the time axis shows the touchdown closely
    open: bool = True  # the area with the charts is
    offered: ChartChoice = ChartChoice("com")  # the chart that would be added next
    removable: ChartChoice | None = None  # that would be removed next; None: the last one

    @property
    def preset(self) -> str:
        """One of `PRESETS`, or `OWN`."""
        for name, preset in PRESETS.items():
            if (preset.charts, preset.landing) == (self.charts, self.landing):
                return name
        for (name, _), charts in _CHARTS.items():
            if (charts, False) == (self.charts, self.landing):
                return name
        # Loads of some joints are the same preset as those of all.
        if tuple(map(_of_all_joints, self.charts)) == PRESETS[TORQUES].charts and not self.landing:
            return TORQUES
        return OWN

    def with_preset(self, name: str) -> PlotChoice:
        """With a preset's charts in place of those that are shown."""
        preset = PRESETS[name]
        return replace(self, charts=preset.charts, landing=preset.landing)

    def with_offered(self) -> PlotChoice:
        """With the offered chart too, once."""
        if self.offered in self.charts or len(self.charts) >= MOST_CHARTS:
            return self
        return replace(self, charts=(*self.charts, self.offered))

    def with_joined(self, dropped: ChartChoice, onto: ChartChoice) -> PlotChoice:
        """With a chart's signals drawn in another one, and no chart of their own."""
        parts = tuple(dict.fromkeys((*onto.parts, *dropped.parts)))
        if dropped == onto or onto not in self.charts or len(parts) > MOST_SIGNALS:
            return self
        joined = replace(parts[0], more=parts[1:])
        charts = (joined if chart == onto else chart for chart in self.charts if chart != dropped)
        return replace(self, charts=tuple(dict.fromkeys(charts)))

    @property
    def to_remove(self) -> ChartChoice:
        """The chart that would be removed next; there is one."""
        return self.removable if self.removable in self.charts else self.charts[-1]

    def without_removed(self) -> PlotChoice:
        """Without the chart that was to be removed, if there is any."""
        charts = tuple(chart for chart in self.charts if chart != self.to_remove)
        return replace(self, charts=charts, removable=None)

    def with_joints(self, kind: str) -> PlotChoice:
        """With the loads of one kind of joints, or of `ALL_JOINTS`."""
        charts = (
            replace(chart, components=(kind,)) if chart.signal in LOADS else chart
            for chart in self.charts
        )
        return replace(self, charts=tuple(dict.fromkeys(charts)))

    @property
    def joints(self) -> str | None:
        """The kind of joints whose loads are shown; None where no loads are."""
        kinds = [chart.components for chart in self.charts if chart.signal in LOADS]
        return (kinds[0] or (ALL_JOINTS,))[0] if kinds else None


LOADS = ("largest_torque_share", "largest_saturation", "largest_speed_share", "power")
"""Signals whose components are kinds of joints."""


def _of_all_joints(chart: ChartChoice) -> ChartChoice:
    return replace(chart, components=(ALL_JOINTS,)) if chart.signal in LOADS else chart


def _each(signal: str, *components: str) -> PlotChoice:
    return PlotChoice((ChartChoice(signal, components, each=True),))


def _all(*charts: tuple[str, str], landing: bool = False) -> PlotChoice:
    return PlotChoice(
        tuple(ChartChoice(signal, (part,) if part else ()) for signal, part in charts), landing
    )


PRESETS: Mapping[str, PlotChoice] = {
    OVERVIEW: _all(
        ("base_angle", "yaw"), ("angular_velocity", "z"), ("inertia", "zz"), ("vertical_force", "")
    ),
    FEW: _all(("angular_velocity", "z"), ("inertia", "zz")),
    "Base angles": _each("base_angle"),
    "Base rates": _each("angular_velocity"),
    "CoM position": _each("com"),
    "CoM velocity": _each("com_velocity"),
    "Linear momentum": _each("linear_momentum"),
    "Angular momentum": _each("angular_momentum"),
    "Principal inertias": _each("principal_inertia"),
    "Contact forces": PlotChoice(
        (ChartChoice("vertical_force"), ChartChoice("foot_force", ("z",), each=True))
    ),
    TORQUES: _all(*((signal, ALL_JOINTS) for signal in LOADS)),
    LANDING: _all(
        ("average_spatial_velocity_norm", ""), ("detection", ""), ("yaw_error", ""), landing=True
    ),
}
"""Choices of charts that have a name."""

_OF_TURNS = {
    "yaw": _all(("inertia", "zz"), ("angular_velocity", "z")),
    "pitch": _all(("inertia", "yy"), ("angular_velocity", "y")),
    "roll": _all(("inertia", "xx"), ("angular_velocity", "x")),
}


def compared(axis: str) -> PlotChoice:
    """Charts of ways to make a jump that turns about an axis: inertia and rate."""
    return _OF_TURNS[axis]


_FLAT = math.radians(3)  # rad of twist; less is no turn to look at
_FORCE = ("vertical_force", "")
# What a jump is about -> its overview.
_ABOUT: Mapping[str, tuple[tuple[str, str], ...]] = {
    "twist": (("base_angle", "yaw"), ("angular_velocity", "z"), ("inertia", "zz"), _FORCE),
    "pitch": (("turned", "y"), ("angular_velocity", "y"), ("inertia", "yy"), _FORCE),
    "roll": (("turned", "x"), ("angular_velocity", "x"), ("inertia", "xx"), _FORCE),
    "forward": (("com", "z"), ("com", "x"), ("base_angle", "pitch"), _FORCE),
    "lateral": (("com", "z"), ("com", "y"), ("base_angle", "roll"), _FORCE),
}
# Of which a small page shows two: of a turn how its rate follows from the inertia.
_FEW_ABOUT = {
    about: (charts[0], _FORCE) if about in ("forward", "lateral") else charts[1:3]
    for about, charts in _ABOUT.items()
}
_CHARTS = {
    (name, about): _all(*charts).charts
    for name, overviews in ((OVERVIEW, _ABOUT), (FEW, _FEW_ABOUT))
    for about, charts in overviews.items()
}


def _about(jump: Jump) -> str:
    if jump.turns:
        return "pitch" if jump.pitch else "roll"
    if abs(jump.twist) >= _FLAT:
        return "twist"
    return "lateral" if abs(jump.lateral) > abs(jump.forward) else "forward"


def of_jump(choice: PlotChoice, jump: Jump) -> PlotChoice:
    """The overview of what this jump is about: of a flip the turn about its axis, of a jump
    without a twist where it goes; any other choice as it is.
    """
    preset = choice.preset
    if preset not in (OVERVIEW, FEW):
        return choice
    charts = _CHARTS[preset, _about(jump)]
    return choice if charts == choice.charts else replace(choice, charts=charts)


DEFAULT = PRESETS[OVERVIEW]
FEWER = PRESETS[FEW]
