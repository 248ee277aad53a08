"""Results of a tab's jobs on its motion: plans, simulations, and why there is none."""

from __future__ import annotations

from dataclasses import replace

from app.motion.planned_motion import presentable
from app.motion.simulated_motion import bake_rollout
from app.motion.so_far import frames_so_far
from app.panel import summaries
from app.panel.status import Word
from app.tab.effects import Keep, LoadRobot, Play, Seek, Submit
from app.tab.events import Reported, RobotLoaded, RobotMissing, SimulateWanted
from app.tab.lanes import Lane
from app.tab.push_comparison import go_on
from app.tab.requests import plan_design, show_plan, simulate, wait_for_rest
from app.tab.state import Shown, TabState
from app.tab.steps import (
    Step,
    also,
    joined,
    played_first,
    submit,
    with_status,
    with_work,
    without_sequel,
)
from app.workers.protocol import (
    Cancelled,
    Failed,
    FindNearest,
    Found,
    PlanJump,
    Planned,
    Prepare,
    Prepared,
    Progress,
    SeedDone,
    Simulated,
    SimulatedSeeds,
    SimulatedSoFar,
    SimulateJump,
    SimulateSeeds,
)
from app.workers.task import Task
from llsrbm.motion.rollout import Rollout
from llsrbm.simulation.surroundings import surroundings

_AHEAD = 0.05
"""s by which a simulation has to be ahead of a replay that begins before its end."""


def take_report(state: TabState, event: Reported) -> Step:
    """Take the report of a job on the motion."""
    report, work = event.report, state.work
    if event.ticket <= work.dropped:
        return state, ()
    if event.ticket != work.newest:
        # While a slider moves, a plan of an older request is worth showing.
        return _show(state, report, event.ticket) if isinstance(report, Planned) else (state, ())
    match report:
        case Progress():
            return _progress(state, report), ()
        case SimulatedSoFar():
            return _show_so_far(state, report)
        case SeedDone():
            return _count_seed(state, report), ()
    task = work.awaited
    state = with_work(state, awaited=None)
    state, before = wait_for_rest(state, task) if isinstance(task, PlanJump) else (state, ())
    return joined(before, _outcome(state, event, task))


def _outcome(state: TabState, event: Reported, task: Task | None) -> Step:
    match event.report:
        case Prepared(robot=robot):
            return state, (LoadRobot(robot),)
        case Planned():
            return _take_plan(state, event.report, event.ticket)
        case Found(nearest=nearest):
            state = with_work(state, nearest=nearest)
            rest = f"{state.work.failure} It works with {nearest.changes}."
            return with_status(state, Word.FAILED, rest), ()
        case Simulated(rollout=rollout):
            state = show_rollout(state, rollout)
            return go_on(state) if state.work.compare is not None else replay(state)
        case SimulatedSeeds():
            return _finish_seeds(state, event.report), ()
        case Failed():
            return _fail(state, event.report, task)
        case Cancelled():
            return _cancelled(state, task), ()
    return state, ()


def show_rollout(state: TabState, rollout: Rollout, source: str = "") -> TabState:
    """The state that shows a simulation of the plan that is shown."""
    shown, robot = state.shown, state.robot
    if shown is None or robot is None:
        return state
    blocks = tuple(surroundings(robot, shown.plan, rollout.scenario).blocks)
    shown = replace(shown, simulated=bake_rollout(rollout), so_far=None, blocks=blocks)
    word, rest = summaries.simulated_line(rollout)
    return with_status(replace(state, shown=shown), word, f"{source}{rest}")


def show_worst(state: TabState) -> Step:
    """The worst of several seeds, in place of the simulation that is shown."""
    seeds = state.seeds
    if seeds is None or seeds.worst is None or seeds.plan is not state.plan:
        return state, ()
    return show_rollout(state, seeds.worst, f"seed {seeds.worst.scenario.seed}: "), ()


def take_robot(state: TabState, event: RobotLoaded) -> Step:
    """A robot can be drawn; what is asked of it can be planned."""
    if event.robot.name != state.design.jump.robot:
        return state, ()  # another one was chosen while it was loaded
    state, effects = draw_robot(state, event)
    return joined(effects, plan_design(state))


def draw_robot(state: TabState, event: RobotLoaded) -> Step:
    """Draw a robot and nothing of another one's motion but the pins; have its meshes made."""
    if state.robot is event.robot:
        return replace(state, prepared=event.prepared or state.prepared), ()
    state = with_work(state, dragging=state.work.dragging.forget())
    state = replace(state, robot=event.robot, prepared=event.prepared, shown=None, seeds=None)
    if event.prepared:
        return state, ()
    ticket = state.tickets + 1
    task = Prepare(event.robot.name)
    return replace(state, tickets=ticket), (Submit(Lane.ROBOT, ticket, task),)


def miss_robot(state: TabState, event: RobotMissing) -> Step:
    """A robot cannot be drawn."""
    if event.robot != state.design.jump.robot:
        return state, ()
    state = replace(state, known=None)
    return with_status(state, Word.FAILED, event.message), ()


# ---- plans


def _show(state: TabState, report: Planned, ticket: int) -> Step:
    """Show a plan, unless a newer one is shown or it is another robot's."""
    robot = state.robot
    if ticket < state.work.shown or robot is None or report.plan.jump.robot != robot.name:
        return state, ()
    first = state.shown is None
    state = show_plan(with_work(state, shown=ticket), report.plan, robot)
    return state, played_first(state) if first else ()


def _take_plan(state: TabState, report: Planned, ticket: int) -> Step:
    step = _show(state, report, ticket)
    state, _ = step
    if state.plan is not report.plan:
        return step
    if state.work.dragging.rests:
        line = summaries.live_line(report.plan)
        return with_status(state, Word.PLANNING, line, busy=True), step[1]
    line = f"{state.work.instead}{summaries.planned_line(report.plan)}"
    state = with_status(state, Word.PLANNED, line)
    state = replace(state, history=replace(state.history, changing=()))
    step = also((state, step[1]), Keep(state.design))
    seeds = state.work.simulate_next
    if seeds is None:
        return step
    return joined(step[1], simulate(with_work(state, simulate_next=None), SimulateWanted(seeds)))


def _fail(state: TabState, report: Failed, task: Task | None) -> Step:
    match task:
        case FindNearest():
            # Beside what stopped the jump that was asked for.
            line = f"{state.work.failure} {report.message}"
            return with_status(state, Word.FAILED, line), ()
        case PlanJump(patient=False):
            # It rests before it is planned with patience; a hand may still be moving.
            return with_status(state, Word.PLANNING, "nothing found quickly ...", busy=True), ()
        case PlanJump(jump, tuning) if report.plan is not None:
            failure = f"{state.work.instead}{report.message}."
            robot = state.robot
            if presentable(report.plan) and robot is not None:
                # Plans of older requests that are still under way do not replace it.
                state = with_work(state, shown=state.work.newest)
                state = show_plan(state, report.plan, robot)
                failure += " The picture shows where the solver stopped, no feasible motion."
            state = with_work(without_sequel(state), failure=failure)
            line = f"{failure} Looking for the nearest jump ..."
            return submit(
                with_status(state, Word.FAILED, line, busy=True), FindNearest(jump, tuning)
            )
        case PlanJump():
            state = with_work(state, dragging=state.work.dragging.forget())
    state = without_sequel(state)
    return with_status(_without_so_far(state), Word.FAILED, report.message), ()


def _cancelled(state: TabState, task: Task | None) -> TabState:
    state = _without_so_far(without_sequel(state))
    match task:
        case SimulateJump() | SimulateSeeds():
            return with_status(state, Word.CANCELLED, "The plan is still there.")
        case FindNearest():
            return with_status(state, Word.CANCELLED, "The search for a feasible jump.")
    state = with_work(state, dragging=state.work.dragging.forget())
    return with_status(state, Word.CANCELLED, "Move a slider to plan again.")


def _progress(state: TabState, report: Progress) -> TabState:
    match state.work.awaited:
        case SimulateJump():
            line = f"({report.text}) ..." if report.share is None else f"{report.share:.0%}"
            return with_status(state, Word.SIMULATING, line, busy=True, share=report.share)
        case SimulateSeeds():
            return state
        case FindNearest():
            line = f"{state.work.failure} ({report.text}) ..."
            return with_status(state, Word.FAILED, line, busy=True)
    line = summaries.progress_line(report.text, report.iteration, report.residual)
    return with_status(state, Word.PLANNING, f"{state.work.instead}{line}", busy=True)


# ---- simulations


def _show_so_far(state: TabState, report: SimulatedSoFar) -> Step:
    task, shown, robot = state.work.awaited, state.shown, state.robot
    if not isinstance(task, SimulateJump) or shown is None or robot is None:
        return state, ()
    start = state.work.replay_from
    if start is not None and report.time[-1] < start + _AHEAD:
        return state, ()  # the robot stays where a hand has just pushed it
    so_far = frames_so_far(robot, report.time, report.qpos)
    blocks = tuple(surroundings(robot, shown.plan, task.scenario).blocks)
    shown = Shown(shown.planned, so_far=so_far, blocks=blocks, source=shown.source)
    return replay(replace(state, shown=shown))


def replay(state: TabState) -> Step:
    """Play what was awaited from where it is worth seeing, if it is not being played already."""
    start = state.work.replay_from
    if start is None:
        return state, ()
    return with_work(state, replay_from=None), (Seek(start), Play())


def _without_so_far(state: TabState) -> TabState:
    shown = state.shown
    if shown is None or shown.so_far is None:
        return state
    return replace(state, shown=replace(shown, so_far=None))


def _count_seed(state: TabState, report: SeedDone) -> TabState:
    seeds = state.seeds
    if seeds is None:
        return state
    seeds = replace(seeds, results=(*seeds.results, report.result))
    done = len(seeds.results)
    landed = sum(result.landed for result in seeds.results)
    line, share = f"{done} of {seeds.count} seeds: {landed} landed so far", done / seeds.count
    return with_status(replace(state, seeds=seeds), Word.SIMULATING, line, busy=True, share=share)


def _finish_seeds(state: TabState, report: SimulatedSeeds) -> TabState:
    seeds = state.seeds
    if seeds is None:
        return state
    seeds = replace(seeds, results=report.results, worst=report.worst)
    landed = all(result.landed for result in report.results)
    word = Word.LANDED if landed else Word.FELL
    return with_status(
        replace(state, seeds=seeds), word, f"in {summaries.seeds_share(report.results)}."
    )
