"""Designs and motions that are kept beside the present one."""

from dataclasses import dataclass, replace

from app.link import BesideChosen, PinPressed
from app.panel.acts import Act
from app.tab.acts import Step, on, reads
from app.tab.design import choose_design
from app.tab.effects import Notify
from app.tab.state import Pin, TabState, free_colour
from llsrbm.request.design import Design


@dataclass(frozen=True)
class PinChosen:
    """A pin was chosen, by its number; -1: none."""

    index: int


def _has_pins(state: TabState) -> bool:
    return bool(state.pins)


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
    foreign = state.foreign
    if foreign is not None and all(pin.motion is not foreign.motion for pin in pins):
        foreign = None
    return replace(state, pins=pins, pin_chosen=len(pins) - 1, foreign=foreign)


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
