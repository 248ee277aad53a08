"""Refining: the whole body's plan, begun from the centroidal one that is shown."""

from __future__ import annotations

from dataclasses import dataclass, replace

from app.panel import summaries
from app.panel.acts import Act
from app.panel.status import Verdict
from app.tab.acts import Step, on, reads, submit
from app.tab.effects import Reported
from app.tab.showing import show_plan
from app.tab.simulating import simulate_next
from app.tab.state import TabState
from app.workers import reports, tasks
from llsrbm.motion.plan import Plan


@dataclass(frozen=True)
class WholeBody:
    """Whether plans shall be refined on the whole body's equations of motion."""

    wanted: bool


reads(
    Act.WHOLE_BODY,
    lambda state, panel: (WholeBody(panel.jump.whole_body.read(state.whole_body, None)[0]), []),
)


@on(WholeBody)
def choose_whole_body(state: TabState, event: WholeBody) -> Step:
    """Refine plans from now on, that which is shown too; or show what it was refined from."""
    state, shown = replace(state, whole_body=event.wanted), state.shown
    if wants_refining(state):
        return refine(state)
    if event.wanted or shown is None or shown.centroidal is None or not state.ready:
        return state, ()
    return _show(state.with_work(awaited=None, dropped=state.work.newest), shown.centroidal)


def wants_refining(state: TabState) -> bool:
    """Whether the plan that is shown is to be refined, and has not been."""
    plan = state.plan
    if not state.whole_body or plan is None or state.planning or not state.ready:
        return False
    return plan.solved and plan.refinement is None


def refine(state: TabState) -> Step:
    """Have the plan that is shown refined; it stays until then."""
    plan = state.plan
    assert plan is not None
    state = replace(state, status=replace(state.status, busy=True))
    return submit(state, tasks.RefinePlan(plan))


@on(tasks.RefinePlan)
def take_refined(state: TabState, event: Reported) -> Step:
    """A plan is being refined, or has been; what was to follow it follows."""
    task = event.job.task
    assert isinstance(task, tasks.RefinePlan)
    match event.report:
        case reports.Progress(text=text, iteration=iteration, residual=residual):
            line = summaries.progress_line(text, iteration, residual)
            return state.with_status(Verdict.PLANNING, line, busy=True), ()
        case reports.Planned(plan=plan) if state.whole_body:
            return _show(state.with_work(shown=state.work.newest), plan, task.plan)
        case reports.Failed(message=message):
            return state.without_sequel().with_status(Verdict.FAILED, message), ()
    return _show(state.without_sequel(), task.plan)


def _show(state: TabState, plan: Plan, centroidal: Plan | None = None) -> Step:
    shown, robot = state.shown, state.robot
    if shown is None or robot is None:
        return state, ()
    reason = shown.reason
    state = show_plan(
        state, plan, robot, shown.source, shown.wanted, reason=reason, centroidal=centroidal
    )
    remark = state.work.instead.strip() or shown.source
    status = summaries.plan_status(plan, remark, shown.wanted, reason)
    return simulate_next(replace(state, status=status))
