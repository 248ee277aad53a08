"""The design: another jump, weights, scenario or example; undone and done again."""

import math
from dataclasses import replace
from typing import Any

from app import gallery
from app.guard.validation import number
from app.link import CardsAsked, ExampleChosen, TuningChosen
from app.panel.acts import Act
from app.panel.jump_types import with_type
from app.panel.tuning import entries_of
from app.panel.view_controls import View
from app.picture.foothold_handles import FootholdDragged
from app.picture.landing_handles import LandingDragged
from app.tab.acts import Corrected, Step, also, keeps, on, reads, update
from app.tab.effects import Notify, Share, ShowGallery, ShowHelp, ShowTuning
from app.tab.planning.known import answer_of, show_again, with_answer
from app.tab.planning.requests import plan_design, plan_or_keep, remember, untitled
from app.tab.state import History, TabState
from llsrbm.request.design import Design
from llsrbm.request.jump import COMPONENTS, PLAIN, Jump
from llsrbm.request.tuning import Tuning

_OTHER_SLIDERS = "The sliders hold {}'s own example now; Undo brings the robot before back."
_SAME = 1e-6  # relative; defaults are shown with six digits


reads(Act.JUMP, lambda state, panel: panel.jump.read(state.design.jump))


@on(Jump)
def choose_jump(state: TabState, jump: Jump) -> Step:
    """Plan another jump, under the weights and limits of the one before if the robot stays."""
    design = state.design
    if jump.robot != design.jump.robot:
        # A request of the other robot is not for this one, but for the type of jump.
        other = _on_another_robot(jump, state)
        note = "" if _alike(other, jump) else _OTHER_SLIDERS.format(state.robots[jump.robot].title)
        state, design = replace(state, note=note, drawing=None), Design(other)
    else:
        if jump.type != design.jump.type:
            jump = with_type(jump, jump.type)
        if jump != design.jump:
            state, design = untitled(state, jump, design.tuning)
    return plan_design(remember(state, design))


def _alike(one: Jump, other: Jump) -> bool:
    """Whether the sliders stand alike."""
    return all(getattr(one, name) == getattr(other, name) for name in COMPONENTS)


def _on_another_robot(jump: Jump, state: TabState) -> Jump:
    """The robot's example; of another type than the examples are, the same request of it."""
    file, jump = state.robots[jump.robot], replace(jump, payload=(), stones=())
    if not file.arms:
        jump = replace(jump, arms=Jump.arms)
    if jump.type == PLAIN:
        example = file.example.model_dump()
        return Jump(robot=jump.robot, model=jump.model, arms=jump.arms, **example)
    ends = file.for_jump(turns=jump.turns).task.model_dump()
    within = {name: min(max(getattr(jump, name), low), high) for name, (low, high) in ends.items()}
    return replace(jump, **within)


@on(LandingDragged)
def drag_landing(state: TabState, dragged: LandingDragged) -> Step:
    """Plan a jump to where a landing's handle was dragged."""
    jump, applied = state.design.jump, dragged.applied_to(state.design.jump, state.ends)
    if jump.route and applied != jump:
        state = _gripped(state, "route", dragged.grip)
    state, effects = choose_jump(state, applied)
    return (state if dragged.held else _at_next_step(state)), effects


@on(FootholdDragged)
def drag_foothold(state: TabState, dragged: FootholdDragged) -> Step:
    """Plan a jump whose foot lands where its handle was dragged; one grip is one step back."""
    robot = state.robot
    if robot is None or not state.ready:
        return state, ()
    jump, grip = dragged.applied_to(state.design.jump, robot), dragged.grip
    if jump != state.design.jump:
        state = _gripped(state, "stones", grip)
    state, effects = choose_jump(state, jump)
    return (state if dragged.held else _at_next_step(state)), effects


def _gripped(state: TabState, field: str, grip: int) -> TabState:
    """Everything that one grip changes of a field of the request is one step."""
    changing = (f"Jump.{field}",) if (field, grip) == state.history.grip else ()
    history = replace(state.history, changing=changing, grip=(field, grip))
    return replace(state, history=history)


def _at_next_step(state: TabState) -> TabState:
    """Whatever is changed next, typed or dragged, is a step of its own."""
    return replace(state, history=replace(state.history, changing=()))


@on(Act.RESET_FOOTHOLDS, enabled=lambda state: bool(state.design.jump.stones))
def reset_footholds(state: TabState) -> Step:
    """Have every foot land where it does by itself."""
    return choose_jump(state, replace(state.design.jump, stones=()))


@on(Tuning)
def choose_tuning(state: TabState, tuning: Tuning) -> Step:
    """Plan under other weights and limits."""
    if tuning != state.design.tuning:
        state, design = untitled(state, state.design.jump, tuning)
        state = remember(state, design)
    return plan_design(state)


@on(Act.RESET_TUNING, enabled=lambda state: state.design.tuning != Tuning())
def reset_tuning(state: TabState) -> Step:
    """Plan with the robot's own weights and limits."""
    return choose_tuning(state, Tuning())


@on(TuningChosen)
def choose_number(state: TabState, event: TuningChosen) -> Step:
    """Plan with another weight or limit, or with the robot's own again."""
    robot = state.robot
    if robot is None or not state.ready:
        return state, ()
    entries = entries_of(robot, state.design.jump.type)
    entry = next((e for e in entries if (e.group, e.name) == (event.group, event.name)), None)
    if entry is None:
        return state, (Notify("Not changed", f"{robot.file.title} has no such number."),)
    tuning = state.design.tuning
    wrong: list[str] = []
    given = {"weights": dict(tuning.weights), "limits": dict(tuning.limits)}
    given[entry.group].pop(entry.name, None)
    if event.value is not None:
        value = number(entry.title, event.value, (entry.lowest, entry.highest), wrong)
        if not math.isclose(value, entry.default, rel_tol=_SAME, abs_tol=_SAME):
            given[entry.group][entry.name] = value
    chosen: Any = Tuning(**given)
    if not wrong:
        return update(state, chosen)
    # The page shows what was typed, also where what comes of it is what there was before.
    return also(update(state, Corrected(chosen, tuple(wrong))), ShowTuning(chosen))


@on(Act.EXAMPLES)
def show_examples(state: TabState) -> Step:
    """Show the gallery."""
    return state, (ShowGallery(),)


@on(CardsAsked)
def send_cards(state: TabState, _: CardsAsked) -> Step:
    """Have the page keep the gallery's cards."""
    return state, (ShowGallery(shown=False),)


@on(Act.HELP)
def show_help(state: TabState) -> Step:
    """Show the help."""
    return state, (ShowHelp(),)


@on(ExampleChosen)
def choose_example(state: TabState, event: ExampleChosen) -> Step:
    """Plan the example of that name."""
    design = gallery.designs().get(event.name)
    return (state, ()) if design is None else choose_design(state, design)


@on(Design)
def choose_design(state: TabState, design: Design) -> Step:
    """Plan an example."""
    state = replace(state, note=design.note, drawing=None)
    return plan_or_keep(remember(state, design, settled=True))


@on(Act.SHARE)
def share(state: TabState) -> Step:
    """Make a link that opens the design."""
    return state, (Share(state.design),)


# ---- undone and done again


@on(Act.UNDO, enabled=lambda state: bool(state.history.back))
def undo(state: TabState) -> Step:
    """Back to the design before."""
    history = state.history
    if not history.back:
        return state, ()
    back, forth = history.back[:-1], (*history.forth, state.design)
    return _go(state, history.back[-1], History(back, forth))


@on(Act.REDO, enabled=lambda state: bool(state.history.forth))
def redo(state: TabState) -> Step:
    """Forth to the design that was undone."""
    history = state.history
    if not history.forth:
        return state, ()
    back, forth = (*history.back, state.design), history.forth[:-1]
    return _go(state, history.forth[-1], History(back, forth))


def _go(state: TabState, design: Design, history: History) -> Step:
    state = with_answer(state).without_sequel().with_work(instead="")
    state = replace(state, design=design, history=history, note=design.note, comparing=None)
    known = answer_of(state)
    return plan_or_keep(state) if known is None or not state.ready else show_again(state, known)


# ---- what is drawn of it


reads(Act.VIEW, lambda state, panel: panel.view.fields.read(state.view, None))


keeps(View, "view")
