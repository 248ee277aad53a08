"""Answers to a request: its plan that is shown, the nearest one, or a refusal."""

from dataclasses import replace

from app.motion.baked import presentable
from app.panel import summaries
from app.panel.status import Verdict
from app.tab.acts import Step, joined, on, played_first
from app.tab.effects import After, Queue, Reported
from app.tab.planning.beginning import take_draft
from app.tab.planning.feasible import learn
from app.tab.planning.refining import FOLLOWS
from app.tab.planning.requests import ANSWERS, PLAN_AGAIN, Rested, settle
from app.tab.showing import ended, show_plan
from app.tab.state import TabState
from app.workers import reports, tasks
from llsrbm.motion.plan import Plan


@on(tasks.PlanJump)
def take_plan_report(state: TabState, event: Reported) -> Step:
    """A plan is being made, or has been, or there is none; or an older request has its plan."""
    report, task = event.report, event.job.task
    assert isinstance(task, tasks.PlanJump)
    if event.job.queue is Queue.BEGINNING:
        return take_draft(state, report), ()
    if event.ticket != state.work.newest:
        return _answer(state, report, event.ticket)
    if isinstance(report, reports.Progress):
        if state.status.verdict in ANSWERS:
            return state, ()
        line = summaries.progress_line(report.text, report.iteration)
        line = f"{state.work.instead}{line}"
        return state.with_status(Verdict.PLANNING, line, busy=True, lasts=report.lasts), ()
    plan = report.plan if isinstance(report, reports.Planned) else None
    dragging = state.work.dragging.answered(task, plan)
    state = learn(state, report, task).with_work(dragging=dragging)
    at_once = dragging.rests and dragging.over
    before = (After(0.0, Rested(dragging.rest)),) if at_once else ()
    return joined(before, _take_outcome(state, report))


def _take_outcome(state: TabState, report: reports.Report) -> Step:
    match report:
        case reports.Refused(nearest=None):
            return _refuse(state, report)
        case reports.Planned() | reports.Refused():
            return _take_plan(state, report)
    return ended(state.forgetting(), report, PLAN_AGAIN), ()


def _take_plan(state: TabState, report: reports.Planned | reports.Refused) -> Step:
    """The newest request has its plan, or the nearest one."""
    step = _answer(state, report, state.work.newest)
    state, effects = step
    if state.work.shown != state.work.newest or state.work.dragging.rests:
        return step
    return joined(effects, settle(state))


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
        follows = FOLLOWS if state.whole_body and plan.refinement is None else ""
        status = summaries.plan_status(plan, state.work.instead.strip(), wanted, reason, follows)
        state = replace(state, status=replace(status, busy=True))
    return state, played_first(state) if first else ()
