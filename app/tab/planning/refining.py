"""The whole body's plan, begun from the draft that is shown, once its request has rested."""

from dataclasses import dataclass, replace

from app.panel import summaries
from app.panel.acts import Act
from app.panel.status import Status, Verdict
from app.tab.acts import Step, joined, on, reads, submit
from app.tab.effects import Reported
from app.tab.planning.beginning import draft_later
from app.tab.showing import show_given, show_plan
from app.tab.shown import Given, Shown
from app.tab.simulating import simulate_next
from app.tab.state import TabState
from app.workers import reports, tasks
from llsrbm.motion.plan import Plan

FOLLOWS = "(the whole body's plan follows) ..."
"""Behind the verdict on a draft that will be replaced."""


@dataclass(frozen=True)
class WholeBody:
    """Whether drafts shall be replaced by plans of the whole body's equations of motion."""

    wanted: bool


reads(
    Act.WHOLE_BODY,
    lambda state, panel: (WholeBody(panel.jump.whole_body.read(state.whole_body, None)[0]), []),
)


@on(WholeBody)
def choose_whole_body(state: TabState, event: WholeBody) -> Step:
    """Have the whole body's plans from now on, of what is shown too; or stay with drafts."""
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
    shown = state.shown
    assert shown is not None
    state = replace(state, status=_status(state, shown, FOLLOWS))
    return submit(state, tasks.RefinePlan(shown.plan, shown.request))


def show_given_refined(state: TabState, given: Given) -> Step:
    """Show a motion that is there already; the whole body's follows a draft of the tab's own."""
    state, effects = show_given(state, given)
    if given.source or given.rollout is not None or not wants_refining(state):
        return draft_later((state, effects))
    return joined(effects, refine(state))


@on(tasks.RefinePlan)
def take_refined(state: TabState, event: Reported) -> Step:
    """A plan is being refined, or has been; what was to follow it follows."""
    task = event.job.task
    assert isinstance(task, tasks.RefinePlan)
    match event.report:
        case reports.Progress(text=text, iteration=iteration, lasts=lasts):
            line = summaries.progress_line(text, iteration)
            if state.shown is None:
                return state, ()
            status = replace(_status(state, state.shown, line), lasts=lasts)
            return replace(state, status=status), ()
        case reports.Planned(plan=plan) if state.whole_body:
            return _show(state.with_work(shown=state.work.newest), plan, task.plan)
        case reports.Refused(reason=reason, nearest=Plan() as less) if state.whole_body:
            state = state.with_work(shown=state.work.newest)
            return _show(state, less, task.plan, reason)
        case reports.Failed(message=message):
            return state.without_sequel().with_status(Verdict.FAILED, message), ()
    return _show(state.without_sequel(), task.plan)


def _show(
    state: TabState, plan: Plan, centroidal: Plan | None = None, stopped_by: str = ""
) -> Step:
    """Show a plan of the whole body, or its draft again; `stopped_by`: why it is of less."""
    shown, robot = state.shown, state.robot
    if shown is None or robot is None:
        return state, ()
    wanted, reason = shown.wanted, stopped_by or shown.reason
    if stopped_by and wanted is None:
        wanted = shown.plan.jump
    elif wanted == plan.jump:  # a draft again, of which the whole body does less; or all of it
        wanted, reason = None, ""
    state = show_plan(
        state, plan, robot, shown.source, wanted, reason=reason, centroidal=centroidal
    )
    assert state.shown is not None
    return simulate_next(replace(state, status=_status(state, state.shown)))


def _status(state: TabState, shown: Shown, follows: str = "") -> Status:
    """The verdict on the plan that is shown; `follows`: as `plan_status` has it."""
    remark = state.work.instead.strip() or shown.source
    status = summaries.plan_status(shown.plan, remark, shown.wanted, shown.reason, follows)
    return replace(status, busy=bool(follows))
