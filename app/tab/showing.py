"""The plan that a tab shows, and the simulation that followed it."""

from dataclasses import replace

from app.motion.baked import bake_plan, bake_rollout
from app.panel import summaries
from app.panel.file_controls import SIMULATION
from app.panel.status import Verdict
from app.tab.acts import Step, played_first
from app.tab.effects import Effect, Keep, LoadRobot
from app.tab.shown import Given, Shown
from app.tab.state import TabState
from app.workers import reports
from llsrbm.analysis.wording import worst_violation
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.surroundings import surroundings
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.robots import Robot


def show_plan(
    state: TabState,
    plan: Plan,
    robot: Robot,
    source: str = "",
    wanted: Jump | None = None,
    *,
    reason: str = "",
    centroidal: Plan | None = None,
) -> TabState:
    """The state that shows a plan, see `Shown`; simulations of another plan go."""
    blocks = surroundings(robot, plan, Scenario()).blocks
    shown = Shown(
        bake_plan(plan, robot),
        blocks=blocks,
        source=source,
        wanted=wanted,
        reason=reason,
        centroidal=centroidal,
    )
    return replace(state, shown=shown, seeds=None)


def show_rollout(
    state: TabState, rollout: Rollout, scenario: Scenario, source: str = ""
) -> TabState:
    """The state that shows a simulation of the shown plan, for which `scenario` was requested."""
    shown, robot = state.shown, state.robot
    if shown is None or robot is None:
        return state
    if shown.simulated is None:  # there is a choice again, and this is the first of it
        state = replace(state, export=replace(state.export, of=SIMULATION))
    around = surroundings(robot, shown.plan, rollout.scenario)
    simulated = bake_rollout(rollout)
    shown = replace(
        shown, simulated=simulated, scenario=scenario, so_far=None, blocks=around.blocks
    )
    status = summaries.simulated_status(rollout, source)
    if around.in_mid_flight:
        rest = f"{status.rest.removesuffix('.')}. {around.in_mid_flight}".removeprefix(". ")
        status = replace(status, rest=rest)
    return replace(state, shown=shown, status=status)


def show_given(state: TabState, given: Given) -> Step:
    """Show a motion of the design as if it was planned just now, once its robot can be drawn."""
    plan, robot = given.plan, state.robot
    if robot is None or robot.name != plan.jump.robot:
        return replace(state, given=given), (LoadRobot(plan.jump.robot),)
    play: tuple[Effect, ...] = played_first(state) if state.shown is None else ()
    work = state.work
    dragging = work.dragging.done(plan.jump, plan.tuning)
    state = replace(state.without_sequel(), given=None, note=given.note or state.note)
    state = replace(state, comparing=None)
    state = state.with_work(awaited=None, dropped=work.newest, dragging=dragging)
    state = show_plan(state, plan, robot, given.source)
    if given.rollout is not None:
        state = show_rollout(state, given.rollout, given.rollout.scenario, given.source)
    elif plan.solved:
        state = replace(state, status=summaries.plan_status(plan, given.source))
    else:
        worst = worst_violation(plan)
        source = f"{given.source}: " if given.source else ""
        line = f"{source}the planner did not converge, largest violation {worst}."
        state = state.with_status(Verdict.FAILED, line)
    return state, (Keep(state.design), *play)


def ended(state: TabState, report: reports.Report, after_cancelling: str) -> TabState:
    """The state after a job without a result; `after_cancelling`: words on one that was stopped."""
    state = _without_so_far(state.without_sequel())
    if isinstance(report, reports.Failed):
        return state.with_status(Verdict.FAILED, report.message)
    assert isinstance(report, reports.Cancelled)
    return state.with_status(Verdict.CANCELLED, after_cancelling)


def _without_so_far(state: TabState) -> TabState:
    """Without the beginning of a simulation that has no end."""
    shown = state.shown
    if shown is None or shown.so_far is None:
        return state
    return replace(state, shown=replace(shown, so_far=None))
