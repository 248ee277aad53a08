"""The picture is asked what a part of the robot does; what it has goes into the plots."""

from __future__ import annotations

from dataclasses import replace

from app.link import PartAsked, PartPlotted
from app.plots.charts import shown_layers
from app.plots.readings import reading, rows_of
from app.tab.acts import Step, on
from app.tab.effects import ShowPart
from app.tab.state import TabState


@on(PartAsked)
def read_part(state: TabState, event: PartAsked) -> Step:
    """Say what a part does over the whole motion."""
    shown, robot = state.shown, state.robot
    if shown is None or robot is None or not state.ready:
        return state, ()
    layers = shown_layers(shown.planned, state.rollout)
    return state, (ShowPart(reading(event.part, robot, layers)),)


@on(PartPlotted)
def plot_part(state: TabState, event: PartPlotted) -> TabState:
    """Have a row of a part as a chart too."""
    if state.robot is None:
        return state
    charts = [*rows_of(event.part, state.robot).values()]
    if event.row >= len(charts):
        return state
    offered = state.plots.offered
    plots = replace(state.plots, offered=charts[event.row], open=True).with_offered()
    return replace(state, plots=replace(plots, offered=offered))
