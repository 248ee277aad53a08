"""Designs and motions that are kept beside the present one; a push simulated twice."""

from __future__ import annotations

from dataclasses import dataclass, replace

from app.link import BesideChosen, PinPressed
from app.panel.acts import Act
from app.tab.acts import Step, on, reads
from app.tab.design import choose_design
from app.tab.effects import Notify
from app.tab.planning.requests import plan_design, remember
from app.tab.pushing import replay_start
from app.tab.simulating import simulate
from app.tab.state import Comparison, Pin, TabState, free_colour
from llsrbm.request.design import Design
from llsrbm.request.jump import FREE, HELD, Jump

_SIMPLE = "srbm"  # The model that others are compared with; it is compared with the default one


@dataclass(frozen=True)
class PinChosen:
    """A pin was chosen, by its number; -1: none."""

    index: int


def _has_pins(state: TabState) -> bool:
    return bool(state.pins)


def _is_pushed(state: TabState) -> bool:
    return bool(state.design.scenario.pushes)


@on(
    Act.PIN,
    enabled=lambda state: state.shown is not None and free_colour(state.pins) is not None,
)
def pin(state: TabState) -> TabState:
    """Keep the motion that is shown beside the next ones."""
    shown, colour = state.shown, free_colour(state.pins)
    if shown is None or colour is None:
        return state
    plan, rollout = shown.plan, shown.rollout
    scenario = state.design.scenario if rollout is None else rollout.scenario
    design = Design(plan.jump, plan.tuning, scenario)
    pinned = Pin(shown.planned, shown.simulated, design, colour)
    return replace(state, pins=(*state.pins, pinned), pin_chosen=len(state.pins))


reads(Act.PINNED, lambda _, panel: (PinChosen(panel.comparison.chosen), []))


@on(PinChosen)
def choose_pin(state: TabState, event: PinChosen) -> TabState:
    """Choose a pin, or none."""
    return replace(state, pin_chosen=event.index if event.index < len(state.pins) else -1)


@on(Act.UNPIN, visible=_has_pins)
def unpin(state: TabState) -> TabState:
    """Let go of the pin that is chosen."""
    pins = tuple(each for index, each in enumerate(state.pins) if index != state.pin_chosen)
    return replace(state, pins=pins, pin_chosen=len(pins) - 1)


@on(PinPressed)
def press_pin(state: TabState, event: PinPressed) -> Step:
    """Use the design of a pin, or let go of it."""
    if event.index >= len(state.pins):
        return state, ()
    state = replace(state, pin_chosen=event.index)
    return use_pinned(state) if event.act == "use" else (unpin(state), ())


@on(BesideChosen)
def stand_beside(state: TabState, event: BesideChosen) -> TabState:
    """Have pinned robots stand beside the one that is shown, or where they are."""
    return replace(state, beside=event.on)


@on(Act.USE_PINNED, visible=_has_pins)
def use_pinned(state: TabState) -> Step:
    """Make the design of the chosen pin the present one."""
    if not 0 <= state.pin_chosen < len(state.pins):
        return state, ()
    design = state.pins[state.pin_chosen].design
    if design is None:
        body = "Imported motions have no design to use."
        return state, (Notify("Not used", body),)
    return choose_design(state, design)


# ---- simulated twice


@on(Act.COMPARE_REPLANNING, visible=_is_pushed)
def compare_replanning(state: TabState) -> Step:
    """Simulate with and without replanning, and play both side by side."""
    return _compare(state, Comparison("replanning"))


@on(Act.COMPARE_MODEL, visible=_is_pushed)
def compare_model(state: TabState) -> Step:
    """Simulate plans of two models, and play both side by side."""
    return _compare(state, Comparison("model"))


@on(Act.COMPARE_ARMS, visible=lambda state: _is_pushed(state) and bool(state.file.arms))
def compare_arms(state: TabState) -> Step:
    """Simulate plans with free and with held arms, and play both side by side."""
    return _compare(state, Comparison("arms"))


def _compare(state: TabState, comparison: Comparison) -> Step:
    """Simulate the design, unless that simulation is shown, and then with the one change."""
    if state.plan is None or state.planning or not state.ready:
        return state, (Notify("Not compared", "There is no plan yet."),)
    if free_colour(state.pins) is None:
        body = "No more can be pinned: unpin one in the tab Results first."
        return state, (Notify("Not compared", body),)
    shown, rollout, design = state.shown, state.rollout, state.design
    simulated = shown and rollout and (shown.request, shown.plan.tuning, rollout.scenario)
    if simulated == (design.jump, design.tuning, design.scenario):
        return go_on(state, comparison)
    return simulate(state.with_work(compare=comparison))


@on(Comparison)
def go_on(state: TabState, comparison: Comparison) -> Step:
    """Pin the simulation that is shown, and simulate the other one."""
    state, design = pin(state).with_work(compare=None), state.design
    if comparison.by == "replanning":
        scenario = replace(design.scenario, replan=not design.scenario.replan)
        state = remember(state, replace(design, scenario=scenario), settled=True)
        state, effects = simulate(state)
        return state.with_work(replay_from=replay_start(state)), effects
    changed = replace(design, jump=_changed(design.jump, comparison), title="", note="")
    state, effects = plan_design(remember(state, changed, settled=True))
    return state.with_work(simulate_next=0, replay_from=replay_start(state)), effects


def _changed(jump: Jump, comparison: Comparison) -> Jump:
    if comparison.by == "arms":
        return replace(jump, arms=HELD if jump.arms == FREE else FREE)
    return replace(jump, model=Jump.model if jump.model == _SIMPLE else _SIMPLE)
