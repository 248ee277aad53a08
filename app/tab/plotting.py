"""The charts: which are shown, and their lines as a file."""

from collections.abc import Mapping
from dataclasses import replace

from app.link import ChartDropped
from app.motion.baked import ForeignMotion
from app.panel.acts import Act
from app.plots.charts import (
    Layer,
    charts,
    contending_layers,
    csv_of,
    pinned_layer,
    shown_layers,
)
from app.plots.choice import MOST_CHARTS, PlotChoice
from app.tab.acts import Step, on, reads
from app.tab.effects import Download
from app.tab.state import TabState
from llsrbm.look.titles import decisions_of, titles_of
from llsrbm.request.jump import Jump
from llsrbm.robots import RobotFile


def titles(state: TabState) -> tuple[str, ...]:
    """Names of the design that is shown, and of what is pinned: by what they differ.

    A repaired motion has its file's, as long as it is shown.
    """
    shown, foreign = state.shown, state.foreign
    assert shown is not None
    known = [
        decisions_of(shown.rollout or shown.plan),
        *(pin.decisions for pin in state.pins if pin.decisions is not None),
    ]
    found = iter(
        titles_of([(_titled(jump, state.robots), tuning, scene) for jump, tuning, scene in known])
    )
    first = next(found)
    if foreign is not None and foreign.is_shown(shown.plan):
        first = foreign.repaired_name
    names = [
        pin.motion.name if isinstance(pin.motion, ForeignMotion) else next(found)
        for pin in state.pins
    ]
    return (first, *names)


def _titled(jump: Jump, robots: Mapping[str, RobotFile]) -> Jump:
    """The jump with its robot's title, but for the first robot, which titles leave out."""
    if jump.robot == Jump().robot or jump.robot not in robots:
        return jump
    return replace(jump, robot=robots[jump.robot].title)


def layers_of(state: TabState) -> tuple[Layer, ...]:
    """Everything plotted, in the order in which it is drawn: pins, plan, simulation.

    Of ways that are compared each one's plan and simulation.
    """
    shown, comparing = state.shown, state.comparing
    if comparing is not None and comparing.last is not None:
        return tuple(
            layer
            for each in comparing.present
            for layer in contending_layers(
                each.name,
                each.colour,
                each.solid.planned,
                each.simulated.rollout,
                pinned=each is not comparing.last,
            )
        )
    if shown is None:
        return ()
    _, *names = titles(state)
    pins = (
        pinned_layer(name, pin.colour, pin.motion, pin.rollout)
        for name, pin in zip(names, state.pins, strict=True)
    )
    return (*pins, *shown_layers(shown.planned, shown.rollout))


reads(Act.PLOTS, lambda state, panel: panel.plots.fields.read(state.plots_seen, ()))
reads(Act.PLOT_AREA, lambda state, panel: (panel.plots.read_area(state.plots_seen), []))


@on(PlotChoice)
def choose_plots(state: TabState, choice: PlotChoice) -> TabState:
    """Plot other charts; those of a comparison are its own."""
    comparing = state.comparing
    if comparing is None or comparing.last is None:
        return replace(state, plots=choice)
    plots = replace(state.plots, open=choice.open)
    return replace(state, comparing=replace(comparing, plots=choice), plots=plots)


@on(
    Act.ADD_CHART,
    enabled=lambda state: (
        state.plots_seen.offered not in state.plots_seen.charts
        and len(state.plots_seen.charts) < MOST_CHARTS
    ),
)
def add_chart(state: TabState) -> TabState:
    """Plot the chart that is on offer, too."""
    return choose_plots(state, state.plots_seen.with_offered())


@on(Act.REMOVE_CHART, enabled=lambda state: bool(state.plots_seen.charts))
def remove_chart(state: TabState) -> TabState:
    """Plot a chart no more."""
    return choose_plots(state, state.plots_seen.without_removed())


@on(ChartDropped)
def join_charts(state: TabState, event: ChartDropped) -> TabState:
    """Draw a chart's signals in the chart that they were dropped onto."""
    choice = state.plots_seen
    shown = {chart.heading: chart.source for chart in charts(choice, layers_of(state))}
    source = choice.offered if event.chart is None else shown.get(event.chart)
    onto = shown.get(event.onto)
    if source is None or onto is None:
        return state
    if onto not in choice.charts or (event.chart and source not in choice.charts):
        choice = replace(choice, charts=tuple(shown.values()))  # a chart each, one by one
    return choose_plots(state, choice.with_joined(source, onto))


@on(
    Act.SAVE_LINES,
    enabled=lambda state: state.seen is not None and bool(state.plots_seen.charts),
)
def save_lines(state: TabState) -> Step:
    """Send the lines that are shown as a table."""
    content = csv_of(layers_of(state), state.plots_seen)
    return state, (Download("plots.csv", content),)
