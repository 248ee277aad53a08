"""Simulating: the whole robot follows the plan, once or under several disturbances."""

import math
from dataclasses import dataclass, replace

from app.motion.baked import frames_so_far
from app.panel import summaries
from app.panel.acts import Act
from app.panel.status import Status, Verdict
from app.tab.acts import Step, also, on, reads, submit
from app.tab.effects import Keep, Notify, Play, Reported, Seek
from app.tab.showing import ended, show_rollout
from app.tab.state import Seeds, TabState
from app.workers import reports, tasks
from llsrbm.motion.surroundings import surroundings
from llsrbm.number_text import percent

SEEDS = 20  # Disturbances that are tried together; the robustness benchmark's number

THROUGH_WIRE = "robot simulator"
_AHEAD = 0.05  # s by which a simulation has to be ahead of a replay that begins before its end


@on(Act.SIMULATE)
def simulate(state: TabState, seeds: int = 0) -> Step:
    """Simulate the plan that is shown or awaited, with so many seeds; 0: once, as designed."""
    plan, scenario = state.plan, state.design.scenario
    state = replace(state, comparing=None)
    if state.ready and state.planning:
        return state.with_work(simulate_next=seeds), ()
    if not state.ready or plan is None:
        return state, (Notify("Not simulated", "There is no plan yet."),)
    if not plan.solved:
        reason = "The planner did not converge, so there is no motion to follow."
        return state, (Notify("Not simulated", reason),)
    if seeds:
        state = replace(state, seeds=Seeds(plan, scenario, seeds))
        state = state.with_status(Verdict.SIMULATING, f"{seeds} seeds ...", busy=True)
        return submit(state, tasks.SimulateSeeds(plan, scenario, tuple(range(seeds))))
    state = state.with_status(Verdict.SIMULATING, "...", busy=True)
    return also(submit(state, tasks.SimulateJump(plan, scenario)), Keep(state.design))


@on(tasks.SimulateJump)
def take_simulation(state: TabState, event: Reported) -> Step:
    """A simulation is under way, or complete."""
    report, task = event.report, event.job.task
    assert isinstance(task, tasks.SimulateJump)
    match report:
        case reports.Progress(text=text, share=share, lasts=lasts):
            line = f"({text}) ..." if share is None else percent(share)
            state = state.with_status(Verdict.SIMULATING, line, busy=True, share=share, lasts=lasts)
            return state, ()
        case reports.SimulatedSoFar():
            return _show_so_far(state, report, task)
        case reports.Simulated(rollout=rollout):
            state = show_rollout(state, rollout, task.scenario, THROUGH_WIRE if task.wire else "")
            if task.wire:
                return state, ()
            took = rollout.duration / (rollout.outcome.real_time_factor or math.inf)
            state = replace(state, simulated_in=took)
            return replay(state)
    return ended(state, report, "The plan is still there."), ()


@dataclass(frozen=True)
class Automatically:
    """Whether what changes shall be simulated again by itself."""

    wanted: bool


reads(
    Act.AUTOMATIC,
    lambda state, panel: (
        Automatically(panel.scenario.automatic.read(state.automatic, None)[0]),
        [],
    ),
)


@on(Automatically)
def choose_automatic(state: TabState, event: Automatically) -> Step:
    """Simulate by itself from now on, or only when Simulate is pressed."""
    return simulate_again(replace(state, automatically=event.wanted))


def simulate_again(state: TabState) -> Step:
    """Simulate the design if it is done by itself, and what is shown is not a simulation of it."""
    shown, awaited = state.shown, state.work.awaited
    if not state.automatic or not state.ready or shown is None or not shown.plan.solved:
        return state, ()
    if state.comparing or state.planning or isinstance(awaited, tasks.SimulateSeeds):
        return state, ()
    if awaited is None and shown.simulated is not None and not state.outdated:
        return state, ()
    return simulate(state)


def simulate_next(state: TabState) -> Step:
    """Simulate the plan that has just come as it was asked for meanwhile, or by itself."""
    seeds = state.work.simulate_next
    if seeds is None:
        return simulate_again(state)
    return simulate(state.with_work(simulate_next=None), seeds)


@on(Act.SEEDS)
def simulate_seeds(state: TabState) -> Step:
    """Simulate the plan under several disturbances."""
    return simulate(state, SEEDS)


@on(tasks.SimulateSeeds)
def take_seeds(state: TabState, event: Reported) -> TabState:
    """One seed more has been simulated, or all of them."""
    seeds, report = state.seeds, event.report
    if seeds is None or isinstance(report, reports.Progress):
        return state
    match report:
        case reports.SeedDone(result=result):
            seeds = replace(seeds, results=(*seeds.results, result))
            done = len(seeds.results)
            landed = sum(each.landed for each in seeds.results)
            line = f"{done} of {seeds.count} seeds: {landed} landed so far"
            return replace(state, seeds=seeds).with_status(
                Verdict.SIMULATING, line, busy=True, share=done / seeds.count
            )
        case reports.SimulatedSeeds(results=results, worst=worst):
            state = replace(state, seeds=replace(seeds, results=results, worst=worst))
            landed_all = all(each.landed for each in results)
            verdict = Verdict.LANDED if landed_all else Verdict.FELL
            return state.with_status(verdict, f"in {summaries.seeds_share(results)}.")
    state = ended(state, report, "The plan is still there.")
    if isinstance(report, reports.Cancelled) and state.rollout is not None:
        state = replace(state, status=summaries.simulated_status(state.rollout))
    return state


@on(Act.WORST, visible=lambda state: state.seeds is not None and state.seeds.worst is not None)
def show_worst(state: TabState) -> TabState:
    """Show the worst of several seeds, in place of the simulation that is shown."""
    seeds = state.seeds
    if seeds is None or seeds.worst is None or seeds.plan is not state.plan:
        return state
    return show_rollout(state, seeds.worst, seeds.scenario, f"seed {seeds.worst.scenario.seed}")


def status_of(state: TabState) -> Status:
    """The status line, which says so where a result is of another scenario."""
    status = state.status
    if not state.outdated or status.verdict not in (Verdict.LANDED, Verdict.FELL):
        return status
    return replace(status, rest=f"{state.remark}: press Simulate", outdated=True)


def _show_so_far(state: TabState, report: reports.SimulatedSoFar, task: tasks.SimulateJump) -> Step:
    shown, robot, start = state.shown, state.robot, state.work.replay_from
    if shown is None or robot is None:
        return state, ()
    if start is not None and report.time[-1] < start + _AHEAD:
        return state, ()  # the robot stays where a hand has just pushed it
    so_far = frames_so_far(robot, report.time, report.qpos)
    blocks = surroundings(robot, shown.plan, task.scenario).blocks
    shown = replace(shown, simulated=None, scenario=None, so_far=so_far, blocks=blocks)
    return replay(replace(state, shown=shown))


def replay(state: TabState) -> Step:
    """Play what was awaited from where it is worth seeing, if it is not being played already."""
    start = state.work.replay_from
    if start is None:
        return state, ()
    return state.with_work(replay_from=None), (Seek(start), Play())
