"""The charts: which are shown, and their lines as a file."""

from __future__ import annotations

from dataclasses import replace

from app.link import ChartDropped
from app.motion.baked import ForeignMotion
from app.panel.acts import Act
from app.panel.jump_controls import titled
from app.plots.charts import Layer, charts, csv_of, pinned_layer, shown_layers
from app.plots.choice import MOST_CHARTS, PlotChoice
from app.tab.acts import Step, keeps, on, reads
from app.tab.effects import Download
from app.tab.state import TabState
from llsrbm.look.titles import Decisions, titles_of


def titles(state: TabState) -> tuple[str, ...]:
    """Names of the design that is shown, and of what is pinned: by what they differ."""
    shown = state.shown
    assert shown is not None
    scenario = None if shown.rollout is None else shown.rollout.scenario
    current: Decisions = (shown.plan.jump, shown.plan.tuning, scenario)
    known = [current, *(pin.decisions for pin in state.pins if pin.decisions is not None)]
    found = iter(
        titles_of([(titled(jump, state.robots), tuning, scene) for jump, tuning, scene in known])
    )
    first = next(found)
    names = [
        pin.motion.name if isinstance(pin.motion, ForeignMotion) else next(found)
        for pin in state.pins
    ]
    return (first, *names)


def layers_of(state: TabState) -> tuple[Layer, ...]:
    """Everything plotted, in the order in which it is drawn: pins, plan, simulation."""
    shown = state.shown
    if shown is None:
        return ()
    _, *names = titles(state)
    pins = (
        pinned_layer(name, pin.colour, pin.motion, pin.rollout)
        for name, pin in zip(names, state.pins, strict=True)
    )
    return (*pins, *shown_layers(shown.planned, shown.rollout))


reads(Act.PLOTS, lambda state, panel: panel.plots.fields.read(state.plots, ()))
reads(Act.PLOT_AREA, lambda state, panel: (panel.plots.read_area(state.plots), []))
keeps(PlotChoice, "plots")


@on(
    Act.ADD_CHART,
    enabled=lambda state: (
        state.plots.offered not in state.plots.charts and len(state.plots.charts) < MOST_CHARTS
    ),
)
def add_chart(state: TabState) -> TabState:
    """Plot the chart that is on offer, too."""
    return replace(state, plots=state.plots.with_offered())


@on(Act.REMOVE_CHART, enabled=lambda state: bool(state.plots.charts))
def remove_chart(state: TabState) -> TabState:
    """Plot a chart no more."""
    return replace(state, plots=state.plots.without_removed())


@on(ChartDropped)
def join_charts(state: TabState, event: ChartDropped) -> TabState:
    """Draw a chart's signals in the chart that they were dropped onto."""
    choice = state.plots
    shown = {chart.heading: chart.source for chart in charts(choice, layers_of(state))}
    source = choice.offered if event.chart is None else shown.get(event.chart)
    onto = shown.get(event.onto)
    if source is None or onto is None:
        return state
    if onto not in choice.charts or (event.chart and source not in choice.charts):
        choice = replace(choice, charts=tuple(shown.values()))  # a chart each, one by one
    return replace(state, plots=choice.with_joined(source, onto))


@on(
    Act.SAVE_LINES,
    enabled=lambda state: state.shown is not None and bool(state.plots.charts),
)
def save_lines(state: TabState) -> Step:
    """Send the lines that are shown as a table."""
    content = csv_of(layers_of(state), state.plots)
    return state, (Download("plots.csv", content),)
