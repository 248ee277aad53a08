"""A visitor's requests: another jump, weights, scenario or design; undone and done again."""

from __future__ import annotations

import math
from dataclasses import fields, replace

from app.guard.validation import number
from app.link import TuningChosen
from app.motion.planned_motion import bake_plan
from app.panel.status import Word
from app.panel.tuning_table import entries_of
from app.panel.types_offered import title_of_type, types_offered, with_type
from app.tab.drag_planning import REST
from app.tab.effects import After, Keep, Notify, ResetControls, Stop
from app.tab.events import (
    DesignChosen,
    JumpChosen,
    JumpOpened,
    Rested,
    ScenarioChosen,
    SimulateWanted,
    TargetDragged,
)
from app.tab.lanes import Lane
from app.tab.state import History, Seeds, Shown, TabState
from app.tab.steps import Step, also, submit, with_status, with_work, without_sequel
from app.workers.protocol import PlanJump, Prepare, SimulateJump, SimulateSeeds
from llsrbm.motion.plan import Plan
from llsrbm.request import jump_types
from llsrbm.request.design import Design
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning
from llsrbm.robots import Robot
from llsrbm.simulation.surroundings import surroundings

_SAME = 1e-6  # relative; defaults are shown with six digits
_UNDONE_AT_MOST = 100  # designs; a hundred bytes each

SEEDS = 20
"""Disturbances that are tried together; the robustness benchmark's number."""


# ---- the design


def choose_jump(state: TabState, event: JumpChosen) -> Step:
    """Plan what the controls of the jump, the weights and the limits say."""
    jump, design = event.jump, state.design
    if jump.robot != design.jump.robot:
        # What was asked of the other robot is not for this one, but for the type of jump.
        state, design = replace(state, note=""), Design(_on_another_robot(jump, state))
    else:
        if jump.type != design.jump.type:
            jump = with_type(jump, jump.type)
        tuning = design.tuning if event.tuning is None else event.tuning
        if (jump, tuning) != (design.jump, design.tuning):
            state, design = _untitled(state, jump, tuning)
    step = plan_design(remember(state, design))
    return _corrected(step, event.complaints)


def _on_another_robot(jump: Jump, state: TabState) -> Jump:
    """The robot's example; of another type than the examples are, the same request of it."""
    file = state.robots[jump.robot]
    if jump.type == jump_types.DEFAULT:
        return Jump(robot=jump.robot, model=jump.model, **file.example.model_dump())
    ends = file.task.model_dump()
    within = {name: min(max(getattr(jump, name), low), high) for name, (low, high) in ends.items()}
    return replace(jump, **within)


def choose_tuning(state: TabState, event: TuningChosen) -> Step:
    """Plan with another weight or limit, or with the robot's own again."""
    robot = state.robot
    if robot is None or not state.ready:
        return state, ()
    entries = {
        (entry.group, entry.name): entry for entry in entries_of(robot, state.design.jump.type)
    }
    entry = entries.get((event.group, event.name))
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
    return choose_jump(state, JumpChosen(state.design.jump, Tuning(**given), tuple(wrong)))


def reset_tuning(state: TabState) -> Step:
    """Plan with the robot's own weights and limits."""
    return choose_jump(state, JumpChosen(state.design.jump, Tuning()))


def drag_target(state: TabState, event: TargetDragged) -> Step:
    """Plan a jump to where the landing handle was dragged."""
    state, design = _untitled(state, event.jump, state.design.tuning)
    return plan_design(remember(state, design))


def choose_scenario(state: TabState, event: ScenarioChosen) -> Step:
    """Simulate in another scenario from now on."""
    state = remember(state, replace(state.design, scenario=event.scenario))
    return _corrected((state, (Keep(state.design),)), event.complaints)


def choose_design(state: TabState, event: DesignChosen) -> Step:
    """Plan an example."""
    state = replace(state, note=event.design.note)
    return plan_design(remember(state, event.design, settled=True))


def open_jump(state: TabState, event: JumpOpened) -> Step:
    """Plan a jump of the atlas, with the limits of its sweep; the scenario stays."""
    state, design = _untitled(state, event.jump, event.tuning)
    step = plan_design(remember(state, design, settled=True))
    if not event.other_drives:
        return step
    body = "The sweep had other drives there; this page plans with the robot's own."
    return also(step, Notify("Opened with other drives", body))


def take_nearest(state: TabState) -> Step:
    """Plan the jump on offer."""
    nearest = state.work.nearest
    if nearest is None:
        return state, ()
    state, design = _untitled(state, nearest.jump, state.design.tuning)
    return plan_design(remember(state, design, settled=True))


def undo(state: TabState) -> Step:
    """Back to the design before."""
    history = state.history
    if not history.back:
        return state, ()
    design = history.back[-1]
    history = replace(
        history, back=history.back[:-1], forth=(*history.forth, state.design), changing=()
    )
    return _go(state, design, history)


def redo(state: TabState) -> Step:
    """Forth to the design that was undone."""
    history = state.history
    if not history.forth:
        return state, ()
    design = history.forth[-1]
    history = replace(
        history, forth=history.forth[:-1], back=(*history.back, state.design), changing=()
    )
    return _go(state, design, history)


def _go(state: TabState, design: Design, history: History) -> Step:
    state = with_work(without_sequel(state), instead="")
    return plan_design(replace(state, design=design, history=history, note=design.note))


def remember(state: TabState, design: Design, *, settled: bool = False) -> TabState:
    """The state with another design, and the one before to go back to.

    Changes of the same numbers that follow each other are one step back.

    Args:
        state: with the design before.
        design: the next one.
        settled: it is one step, whatever comes next.
    """
    if design == state.design:
        return state
    history, changed = state.history, () if settled else _changes(state.design, design)
    if not changed or changed != history.changing:
        back = (*history.back, state.design)[-_UNDONE_AT_MOST:]
        history = replace(history, back=back)
    state = with_work(without_sequel(state), instead="")
    return replace(state, design=design, history=replace(history, forth=(), changing=changed))


def plan_design(state: TabState) -> Step:
    """Plan what the design asks for, unless that is under way; its robot is prepared first.

    A motion that waits for its robot is not waited for any more.
    """
    state, design = replace(state, known=None), state.design
    name = design.jump.robot
    if not state.ready:
        if state.work.awaited == Prepare(name):
            return state, ()
        state = with_work(state, dragging=state.work.dragging.forget(), nearest=None)
        state = with_status(state, Word.PLANNING, "begins when the robot is ready.", busy=True)
        return submit(state, Prepare(name))
    state = _of_a_type_that_it_can(state)
    design = state.design
    dragging, task = state.work.dragging.request(design.jump, design.tuning, state.plan)
    state = with_work(state, dragging=dragging)
    if task is None:
        return state, ()
    return _submit_plan(with_work(state, nearest=None), task)


def _of_a_type_that_it_can(state: TabState) -> TabState:
    """The state with a jump of the default type, if its robot lacks the feet of what is asked."""
    jump, robot = state.design.jump, state.robot
    if robot is None or jump.type in types_offered(robot):
        return state
    default = title_of_type(jump_types.DEFAULT)
    instead = f'{robot.file.title} cannot do "{title_of_type(jump.type)}": "{default}" instead. '
    jump = with_type(jump, jump_types.DEFAULT)
    state, design = _untitled(state, jump, state.design.tuning)
    return with_work(replace(state, design=design), instead=instead)


def rest(state: TabState, event: Rested) -> Step:
    """A request that has rested is planned from scratch."""
    dragging, task = state.work.dragging.rested(event.number)
    if task is None:
        return state, ()
    return _submit_plan(with_work(state, dragging=dragging), task)


def wait_for_rest(state: TabState, task: PlanJump) -> Step:
    """The newest request has its answer; a quick one is planned again when it has rested."""
    dragging = state.work.dragging.answered(task)
    state = with_work(state, dragging=dragging)
    return state, (After(REST, Rested(dragging.rest)),) if dragging.rests else ()


def cancel(state: TabState) -> Step:
    """Give up what is being computed; of a request that rests, planning it from scratch."""
    work = state.work
    state = without_sequel(state)
    if work.awaited is None and work.dragging.rests:
        state = with_work(state, dragging=work.dragging.forget())
        state = with_status(state, Word.CANCELLED, "Move a slider to plan again.")
    return state, (Stop(Lane.MOTION), Stop(Lane.SAVE))


def _submit_plan(state: TabState, task: PlanJump) -> Step:
    following = not task.patient and isinstance(state.work.awaited, PlanJump)
    if not following:
        state = with_status(state, Word.PLANNING, f"{state.work.instead}...", busy=True)
    return submit(state, task)


def _untitled(state: TabState, jump: Jump, tuning: Tuning) -> tuple[TabState, Design]:
    """Another design of the visitor's own: titles and notes are not of it."""
    design = replace(state.design, jump=jump, tuning=tuning, title="", note="")
    return replace(state, note=""), design


def _changes(one: Design, other: Design) -> tuple[str, ...]:
    """Names of the numbers in which two designs differ."""
    pairs = ((one.jump, other.jump), (one.tuning, other.tuning), (one.scenario, other.scenario))
    return tuple(
        f"{type(a).__name__}.{field.name}"
        for a, b in pairs
        for field in fields(a)
        if getattr(a, field.name) != getattr(b, field.name)
    )


def _corrected(step: Step, complaints: tuple[str, ...]) -> Step:
    if not complaints:
        return step
    return also(step, Notify("Corrected", "; ".join(complaints)), ResetControls())


# ---- its simulation


def simulate(state: TabState, event: SimulateWanted) -> Step:
    """Have the whole robot follow the plan that is shown, or the one that is awaited."""
    plan = state.plan
    if state.ready and state.planning:
        return with_work(state, simulate_next=event.seeds), ()
    if not state.ready or plan is None:
        return state, (Notify("Not simulated", "There is no plan yet."),)
    if not plan.solved:
        reason = "The planner did not converge, so there is no motion to follow."
        return state, (Notify("Not simulated", reason),)
    scenario = state.design.scenario
    if event.seeds:
        state = replace(state, seeds=Seeds(plan, event.seeds))
        state = with_status(state, Word.SIMULATING, f"{event.seeds} seeds ...", busy=True)
        return submit(state, SimulateSeeds(plan, scenario, tuple(range(event.seeds))))
    state = with_status(state, Word.SIMULATING, "...", busy=True)
    return also(submit(state, SimulateJump(plan, scenario)), Keep(state.design))


# ---- motions that are there already


def show_plan(state: TabState, plan: Plan, robot: Robot, source: str = "") -> TabState:
    """The state that shows a plan; simulations of another plan go."""
    blocks = tuple(surroundings(robot, plan, Scenario()).blocks)
    shown = Shown(bake_plan(plan, robot), blocks=blocks, source=source)
    return replace(state, shown=shown, seeds=None)
