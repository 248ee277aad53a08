"""A push simulated twice, the first one pinned: with and without replanning, or of two models."""

from __future__ import annotations

from dataclasses import replace

from app.tab import requests
from app.tab.comparison import Pin, free_colour
from app.tab.effects import Notify
from app.tab.events import CompareWanted, SimulateWanted
from app.tab.pushing import replay_start
from app.tab.state import TabState
from app.tab.steps import Step, with_work
from llsrbm.request.design import Design
from llsrbm.request.jump import Jump

_SIMPLE = "srbm"
"""The model that others are compared with; it is compared with the default one."""


def compare(state: TabState, event: CompareWanted) -> Step:
    """Simulate as it is asked for, unless that is shown, and then with the one change."""
    if state.plan is None or state.planning or not state.ready:
        return state, (Notify("Not compared", "There is no plan yet."),)
    if free_colour(state.pins) is None:
        body = "No more can be pinned: unpin one in the tab Figures first."
        return state, (Notify("Not compared", body),)
    state = with_work(state, compare=event.by)
    if _simulated_as_asked(state):
        return go_on(state)
    return requests.simulate(state, SimulateWanted())


def go_on(state: TabState) -> Step:
    """Pin the simulation that is shown, and simulate the other one."""
    by, design = state.work.compare, state.design
    state = with_work(pin(state), compare=None)
    if by == "replanning":
        scenario = replace(design.scenario, replan=not design.scenario.replan)
        state = requests.remember(state, replace(design, scenario=scenario), settled=True)
        state, effects = requests.simulate(state, SimulateWanted())
        return with_work(state, replay_from=replay_start(state)), effects
    model = Jump.model if design.jump.model == _SIMPLE else _SIMPLE
    jump = replace(design.jump, model=model)
    changed = replace(design, jump=jump, title="", note="")
    state, effects = requests.plan_design(requests.remember(state, changed, settled=True))
    state = with_work(state, simulate_next=0, replay_from=replay_start(state))
    return state, effects


def pin(state: TabState) -> TabState:
    """Keep the motion that is shown."""
    shown, colour = state.shown, free_colour(state.pins)
    if shown is None or colour is None:
        return state
    plan, rollout = shown.plan, shown.rollout
    scenario = state.design.scenario if rollout is None else rollout.scenario
    design = Design(plan.jump, plan.tuning, scenario)
    pinned = Pin(shown.planned, shown.simulated, design, colour)
    return replace(state, pins=(*state.pins, pinned), pin_chosen=len(state.pins))


def _simulated_as_asked(state: TabState) -> bool:
    """Whether the simulation that is shown is the present design's."""
    plan, rollout, design = state.plan, state.rollout, state.design
    if plan is None or rollout is None:
        return False
    shown = (plan.jump, plan.tuning, rollout.scenario)
    return shown == (design.jump, design.tuning, design.scenario)
