"""Requests: the design is planned, after it has rested once more; the ones before it."""

from dataclasses import dataclass, fields, replace

from app.panel.acts import Act
from app.panel.jump_types import not_supported, types_offered, with_type
from app.panel.status import Verdict
from app.tab.acts import Step, also, joined, on, submit
from app.tab.effects import After, Keep, Queue, Stop
from app.tab.planning.beginning import draft_later
from app.tab.planning.dragging import REST
from app.tab.planning.known import show_again, with_answer
from app.tab.planning.refining import refine, wants_refining
from app.tab.simulating import simulate_again, simulate_next
from app.tab.state import TabState
from app.workers import tasks
from llsrbm.planning.whole_body.feasible import begins_from_table
from llsrbm.request.design import Design
from llsrbm.request.jump import PLAIN, Jump
from llsrbm.request.tuning import Tuning

ANSWERS = (Verdict.DRAFT, Verdict.NEAREST, Verdict.INFEASIBLE)
"""Status words that may stay until the next answer; `Feasible` is of its own motion alone."""

PLAN_AGAIN = "Move a slider to plan again."
"""The sentence on a request that was given up."""

_UNDONE_AT_MOST = 100  # designs; a hundred bytes each


def plan_design(state: TabState) -> Step:
    """Plan the design, unless that is under way; its robot is prepared first."""
    state = replace(state, given=None)
    name = state.design.jump.robot
    if not state.ready:
        if state.work.awaited == tasks.Prepare(name):
            return state, ()
        state = state.forgetting()
        state = state.with_status(Verdict.PLANNING, "begins when the robot is ready.", busy=True)
        return submit(state, tasks.Prepare(name))
    state = _of_a_supported_type(state)
    design, shown = state.design, state.shown
    start = None if shown is None else shown.centroidal or shown.plan
    dragging, task = state.work.dragging.request(
        design.jump, design.tuning, start, whole_body=state.whole_body
    )
    state = state.with_work(dragging=dragging)
    if task is None:
        return state, ()
    if task.patient:
        return _submit_plan(state, task, follows=False)
    return also(_submit_plan(state, task, follows=True), After(REST, Rested(dragging.rest)))


def plan_or_keep(state: TabState) -> Step:
    """Plan another design; where its plan is there already, have the browser keep it at once, and
    simulate it if that is done by itself.
    """
    step = plan_design(state)
    return step if step[1] else joined((Keep(state.design),), simulate_again(step[0]))


def _submit_plan(state: TabState, task: tasks.PlanJump, *, follows: bool) -> Step:
    """Have a plan made; if it `follows` an answer that is shown, that stays until it is there."""
    if follows and state.status.verdict in ANSWERS:
        state = replace(state, status=replace(state.status, busy=True, old=True))
    else:
        line = f"{state.work.instead or 'the jump '}..."
        state = state.with_status(Verdict.PLANNING, line, busy=True)
    return submit(state, task)


def _of_a_supported_type(state: TabState) -> TabState:
    """The state with a jump of the default type, if its robot lacks the feet of the design's."""
    jump, robot = state.design.jump, state.robot
    if robot is None or jump.type in types_offered(robot):
        return state
    instead = f"{not_supported(robot, jump.type)} "
    jump = with_type(jump, PLAIN)
    state, design = untitled(state, jump, state.design.tuning)
    return replace(state, design=design).with_work(instead=instead)


@dataclass(frozen=True)
class Rested:
    """The request has rested for as long as it has to, see `DragPlanning.rest`."""

    number: int


@on(Rested)
def rest(state: TabState, event: Rested) -> Step:
    """A request that has rested and has its quick answer is planned from scratch: by the whole
    body at once, where the robot has a table of jumps from which such ones begin.
    """
    dragging, task = state.work.dragging.rested(event.number)
    state = state.with_work(dragging=dragging)
    if task is None:
        return state, ()
    shown = state.shown
    drafted = shown is not None and (shown.request, shown.plan.tuning) == (task.jump, task.tuning)
    if drafted and wants_refining(state) and begins_from_table(task.jump, task.tuning):
        return settle(state)
    return _submit_plan(state, task, follows=True)


def settle(state: TabState) -> Step:
    """The design has its draft, or the nearest one: keep it; what is to follow follows."""
    status = replace(state.status, busy=False)
    state = replace(state, status=status, history=replace(state.history, changing=()))
    follow = refine if wants_refining(state) else simulate_next
    return draft_later(joined((Keep(state.design),), follow(state)))


def _searches(state: TabState) -> bool:
    return state.far is not None and state.far.running


def _can_be_cancelled(state: TabState) -> bool:
    """A page that comes in is at work before anything is requested."""
    requested = state.work.newest > 0 or state.work.dragging.rests
    return (state.status.busy and requested) or _searches(state)


@on(Act.CANCEL, visible=_can_be_cancelled)
def cancel(state: TabState) -> Step:
    """Give up what is being computed; of a request that rests, planning it from scratch."""
    work, searches = state.work, _searches(state)
    state = state.without_sequel()
    if work.awaited is None and work.dragging.rests:
        state = state.forgetting()
        state = state.with_status(Verdict.CANCELLED, PLAN_AGAIN)
    return state, (Stop(Queue.MOTION), *([Stop(Queue.LARGEST)] if searches else []))


@on(Act.NEAREST, visible=lambda state: state.shown is not None and state.shown.wanted is not None)
def take_nearest(state: TabState) -> Step:
    """Have the jump that is shown, the nearest, in place of the one that was asked for."""
    shown = state.shown
    if shown is None or shown.wanted is None:
        return state, ()
    state, design = untitled(state, shown.plan.jump, state.design.tuning)
    state = remember(state, design, settled=True)
    return show_again(state, replace(shown, wanted=None, reason=""))


# ---- designs, and those before them


def remember(state: TabState, design: Design, *, settled: bool = False) -> TabState:
    """The state with another design, and the one before to go back to.

    Changes of the same numbers that follow each other are one step back, unless it is `settled`.
    """
    if design == state.design:
        return state
    history, changed = state.history, () if settled else _changes(state.design, design)
    if not changed or changed != history.changing:
        back = (*history.back, state.design)[-_UNDONE_AT_MOST:]
        history = replace(history, back=back)
    state = with_answer(state).without_sequel().with_work(instead="")
    history = replace(history, forth=(), changing=changed)
    return replace(state, design=design, history=history, comparing=None)


def untitled(state: TabState, jump: Jump, tuning: Tuning) -> tuple[TabState, Design]:
    """Another design of the visitor's own: titles and notes are not of it."""
    design = replace(state.design, jump=jump, tuning=tuning, title="", note="")
    return replace(state, note=""), design


def _changes(one: Design, other: Design) -> tuple[str, ...]:
    pairs = ((one.jump, other.jump), (one.tuning, other.tuning), (one.scenario, other.scenario))
    return tuple(
        f"{type(a).__name__}.{field.name}"
        for a, b in pairs
        for field in fields(a)
        if getattr(a, field.name) != getattr(b, field.name)
    )
