"""Planning: from the design, by way of its robot, to its plan that is shown, or the nearest one."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

from app.motion.baked import presentable
from app.panel import summaries
from app.panel.acts import Act
from app.panel.jump_types import not_supported, types_offered, with_type
from app.panel.status import Verdict
from app.tab.acts import (
    Step,
    also,
    joined,
    on,
    outcome,
    played_first,
    submit,
    submit_beside,
)
from app.tab.drag_planning import REST
from app.tab.effects import (
    After,
    Effect,
    Keep,
    LoadRobot,
    Notify,
    Queue,
    Reported,
    RobotLoaded,
    RobotMissing,
    Stop,
)
from app.tab.feasible import learn
from app.tab.refining import refine, wants_refining
from app.tab.showing import show_plan, show_rollout, without_so_far
from app.tab.simulating import simulate_again, simulate_next
from app.tab.state import Given, TabState
from app.workers import reports, tasks
from llsrbm.motion.plan import Plan
from llsrbm.request import jump_types
from llsrbm.request.design import Design
from llsrbm.request.jump import Jump
from llsrbm.request.tuning import Tuning

ANSWERS = (Verdict.FEASIBLE, Verdict.NEAREST, Verdict.INFEASIBLE)
"""Status words that answer a request."""

_UNDONE_AT_MOST = 100  # designs; a hundred bytes each


# ---- requests


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
    design = state.design
    dragging, task = state.work.dragging.request(design.jump, design.tuning, state.plan)
    state = state.with_work(dragging=dragging)
    if task is None:
        return state, ()
    return _submit_plan(state, task, follows=not task.patient)


def plan_or_keep(state: TabState) -> Step:
    """Plan another design; where its plan is there already, have the browser keep it at once, and
    simulate it if that is done by itself.
    """
    step = plan_design(state)
    return step if step[1] else joined((Keep(state.design),), simulate_again(step[0]))


def _submit_plan(state: TabState, task: tasks.PlanJump, *, follows: bool) -> Step:
    """Have a plan made; if it `follows` an answer that is shown, that stays until it is there."""
    if follows and state.status.verdict in ANSWERS:
        state = replace(state, status=replace(state.status, busy=True))
    else:
        state = state.with_status(Verdict.PLANNING, f"{state.work.instead}...", busy=True)
    return submit(state, task)


def _of_a_supported_type(state: TabState) -> TabState:
    """The state with a jump of the default type, if its robot lacks the feet of the design's."""
    jump, robot = state.design.jump, state.robot
    if robot is None or jump.type in types_offered(robot):
        return state
    instead = f"{not_supported(robot, jump.type)} "
    jump = with_type(jump, jump_types.DEFAULT)
    state, design = untitled(state, jump, state.design.tuning)
    return replace(state, design=design).with_work(instead=instead)


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
    state = state.without_sequel().with_work(instead="")
    return replace(state, design=design, history=replace(history, forth=(), changing=changed))


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


@dataclass(frozen=True)
class Rested:
    """The request has rested for as long as it has to, see `DragPlanning.rest`."""

    number: int


@on(Rested)
def rest(state: TabState, event: Rested) -> Step:
    """A request that has rested is planned from scratch."""
    dragging, task = state.work.dragging.rested(event.number)
    if task is None:
        return state, ()
    return _submit_plan(state.with_work(dragging=dragging), task, follows=True)


@on(Act.CANCEL, visible=lambda state: state.status.busy)
def cancel(state: TabState) -> Step:
    """Give up what is being computed; of a request that rests, planning it from scratch."""
    work = state.work
    state = state.without_sequel()
    if work.awaited is None and work.dragging.rests:
        state = state.forgetting()
        state = state.with_status(Verdict.CANCELLED, "Move a slider to plan again.")
    return state, (Stop(Queue.MOTION),)


# ---- reports


@on(Queue.MOTION)
def take_report(state: TabState, event: Reported) -> Step:
    """A job on the motion has something to report: the newest one, or an older plan."""
    report, work = event.report, state.work
    if event.ticket <= work.dropped:
        return state, ()
    if event.ticket != work.newest:
        # While a slider moves, the answer to an older request is worth showing.
        return _answer(state, report, event.ticket)
    task = work.awaited
    if task is None:
        return state, ()
    if isinstance(report, reports.Partial):
        return outcome(state, report, task)
    before: tuple[Effect, ...] = ()
    state = learn(state.with_work(awaited=None), report, task)
    if isinstance(task, tasks.PlanJump):
        state, before = _wait_for_rest(state, task)
    return joined(before, outcome(state, report, task))


def _wait_for_rest(state: TabState, task: tasks.PlanJump) -> Step:
    dragging = state.work.dragging.answered(task)
    state = state.with_work(dragging=dragging)
    return state, (After(REST, Rested(dragging.rest)),) if dragging.rests else ()


@on(tasks.PlanJump)
def take_plan_report(state: TabState, report: reports.Report, _: tasks.PlanJump) -> Step:
    """A plan is being made, or has been, or there is none."""
    match report:
        case reports.Progress():
            if state.status.verdict in ANSWERS:
                return state, ()
            line = summaries.progress_line(report.text, report.iteration, report.residual)
            line = f"{state.work.instead}{line}"
            return state.with_status(Verdict.PLANNING, line, busy=True), ()
        case reports.Refused(nearest=None):
            return _refuse(state, report)
        case reports.Planned() | reports.Refused():
            return _take_plan(state, report)
    return _ended(state.forgetting(), report)


def _take_plan(state: TabState, report: reports.Planned | reports.Refused) -> Step:
    """The newest request has its plan, or the nearest one."""
    step = _answer(state, report, state.work.newest)
    state, effects = step
    if state.work.shown != state.work.newest or state.work.dragging.rests:
        return step
    status = replace(state.status, busy=False)
    state = replace(state, status=status, history=replace(state.history, changing=()))
    step = also((state, effects), Keep(state.design))
    follow = refine if wants_refining(state) else simulate_next
    return joined(step[1], follow(state))


def _refuse(state: TabState, report: reports.Refused) -> Step:
    """There is no plan, and none near it: show where the solver stopped, once it has rested."""
    rests, robot = state.work.dragging.rests, state.robot
    status = summaries.refused_status(report.reason, state.work.instead.strip())
    state = replace(state, status=replace(status, busy=rests))
    if rests:
        return state, ()
    if presentable(report.last) and robot is not None:
        # Plans of older requests that are still under way do not replace it.
        state = show_plan(state.with_work(shown=state.work.newest), report.last, robot)
    return state.without_sequel(), ()


@on(Act.NEAREST, visible=lambda state: state.shown is not None and state.shown.wanted is not None)
def take_nearest(state: TabState) -> Step:
    """Have the jump that is shown, the nearest, in place of the one that was asked for."""
    shown = state.shown
    if shown is None or shown.wanted is None:
        return state, ()
    state, design = untitled(state, shown.plan.jump, state.design.tuning)
    state = replace(state, shown=replace(shown, wanted=None))
    return plan_design(remember(state, design, settled=True))


def _ended(state: TabState, report: reports.Report) -> Step:
    state = without_so_far(state.without_sequel())
    if isinstance(report, reports.Failed):
        return state.with_status(Verdict.FAILED, report.message), ()
    assert isinstance(report, reports.Cancelled)
    return state.with_status(Verdict.CANCELLED, "Move a slider to plan again."), ()


# ---- robots


@on(tasks.Prepare)
def take_prepared(state: TabState, report: reports.Report, _: tasks.Prepare) -> Step:
    """The design's robot can be loaded, or is being prepared."""
    match report:
        case reports.Progress():
            line = summaries.progress_line(report.text, None, None)
            line = f"{state.work.instead}{line}"
            return state.with_status(Verdict.PLANNING, line, busy=True), ()
        case reports.Prepared(robot=robot):
            return state, (LoadRobot(robot),)
        case reports.Failed():
            return _ended(state, report)
    return _ended(state.forgetting(), report)


@on(Queue.ROBOT)
def take_meshes(state: TabState, event: Reported) -> Step:
    """The meshes of a robot that is drawn by its collision shapes have been made."""
    match event.report:
        case reports.Prepared(robot=name) if state.robot is not None and state.robot.name == name:
            return state, (LoadRobot(name),)
        case reports.Failed(message=message):
            return state, (Notify("The robot's meshes are missing", message),)
    return state, ()


@on(RobotLoaded)
def take_robot(state: TabState, event: RobotLoaded) -> Step:
    """A robot can be drawn; then the motion that waits for it is shown, or the design planned."""
    given, name = state.given, event.robot.name
    if event.robot is state.robot and event.prepared and not state.prepared:
        return replace(state, prepared=True), ()  # its meshes have been made
    if given is not None and given.plan.jump.robot == name:
        state, effects = draw_robot(state, event)
        return joined(effects, show_given(state, given))
    if name != state.design.jump.robot:
        return state, ()  # another one was chosen while it was loaded
    state, effects = draw_robot(state, event)
    return joined(effects, plan_design(state))


@on(RobotMissing)
def miss_robot(state: TabState, event: RobotMissing) -> TabState:
    """A robot cannot be drawn."""
    if event.robot != state.design.jump.robot:
        return state
    return replace(state, given=None).with_status(Verdict.FAILED, event.message)


def draw_robot(state: TabState, event: RobotLoaded) -> Step:
    """Draw a robot and nothing of another one's motion but the pins; have its meshes made."""
    if state.robot is event.robot:
        return replace(state, prepared=event.prepared or state.prepared), ()
    state = replace(state.forgetting(), robot=event.robot, prepared=event.prepared)
    state = replace(state, shown=None, seeds=None)
    if event.prepared:
        return state, ()
    return submit_beside(state, Queue.ROBOT, tasks.Prepare(event.robot.name))


# ---- plans that are shown


def _answer(state: TabState, report: reports.Report, ticket: int) -> Step:
    """Show the plan of a job, if it is newer than the one that is shown, and say what it is."""
    match report:
        case reports.Planned(plan=plan):
            wanted, reason = None, ""
        case reports.Refused(nearest=Plan() as plan):
            wanted, reason = report.jump, report.reason
        case _:
            return state, ()
    robot = state.robot
    if ticket < state.work.shown or robot is None or plan.jump.robot != robot.name:
        return state, ()
    first = state.shown is None
    state = show_plan(state.with_work(shown=ticket), plan, robot, wanted=wanted, reason=reason)
    if ticket == state.work.newest or isinstance(state.work.awaited, tasks.PlanJump):
        status = summaries.plan_status(plan, state.work.instead.strip(), wanted, reason)
        state = replace(state, status=replace(status, busy=True))
    return state, played_first(state) if first else ()


def show_given(state: TabState, given: Given) -> Step:
    """Show a motion of the design as if it was planned just now, once its robot can be drawn."""
    plan, robot = given.plan, state.robot
    if robot is None or robot.name != plan.jump.robot:
        return replace(state, given=given), (LoadRobot(plan.jump.robot),)
    play: tuple[Effect, ...] = played_first(state) if state.shown is None else ()
    work = state.work
    dragging, _ = work.dragging.forget().request(plan.jump, plan.tuning, None)
    state = replace(state.without_sequel(), given=None, note=given.note or state.note)
    state = state.with_work(awaited=None, dropped=work.newest, dragging=dragging)
    state = show_plan(state, plan, robot, given.source)
    if given.rollout is not None:
        state = show_rollout(state, given.rollout, given.rollout.scenario, given.source)
    elif plan.solved:
        state = replace(state, status=summaries.plan_status(plan, given.source))
    else:
        worst = summaries.worst(plan.violations)
        source = f"{given.source}: " if given.source else ""
        line = f"{source}the planner did not converge, largest violation {worst}."
        state = state.with_status(Verdict.FAILED, line)
    return state, (Keep(state.design), *play)
