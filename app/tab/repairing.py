"""Repair: another tool's motion that is open is checked, and becomes a plan that can be done."""

from dataclasses import replace

from app.link import RepairAsked
from app.motion.baked import ForeignMotion, bake_foreign
from app.panel import summaries
from app.panel.status import Verdict
from app.tab.acts import Step, also, on, submit, submit_beside
from app.tab.effects import Play, Queue, Reported, Seek
from app.tab.foreign import Foreign, Offer
from app.tab.planning.known import show_again
from app.tab.planning.requests import remember
from app.tab.showing import ended, show_plan
from app.tab.state import TabState
from app.workers import reports, tasks
from app.workers.opened_file import States
from llsrbm.errors import Error
from llsrbm.motion.plan import Plan
from llsrbm.repairing.before import motion_before
from llsrbm.repairing.result import FAILED, Repair
from llsrbm.request.design import Design, dump_design

_LANE = 1  # of checks: beside that of the motion that is shown
_KEPT = "The plan is still there."


# ---- the certificate of the file's motion


def check_foreign(state: TabState, foreign: Foreign) -> Step:
    """Have a motion checked, in place of the one that was opened before."""
    task = tasks.CheckForeign(_states(foreign.motion))
    state, effects = submit_beside(state, Queue.CHECK, task, _LANE)
    return replace(state, foreign=replace(foreign, ticket=state.tickets)), effects


@on(tasks.CheckForeign)
def take_check(state: TabState, event: Reported) -> TabState:
    """The motion is being checked, or has been."""
    foreign = state.foreign
    if foreign is None or event.ticket != foreign.ticket:
        return state
    match event.report:
        case reports.Checked(certificate=certificate):
            foreign = replace(foreign, ticket=0, before=certificate)
        case reports.Failed(message=message):
            foreign = replace(foreign, ticket=0, why_not=f"Not checked: {message}")
        case reports.Cancelled():
            foreign = replace(foreign, ticket=0, why_not="Not checked: it was stopped.")
    return replace(state, foreign=foreign)


def _states(motion: ForeignMotion) -> States:
    return States.of(motion.motion, motion.motion.robot.name)


# ---- the repair


def offer(state: TabState) -> Offer:
    """Whether a press has the motion repaired by now: it is of the present robot, and not yet."""
    foreign = state.foreign
    if foreign is None or foreign.hopeless or foreign.is_shown(state.plan):
        return ""
    if foreign.robot != state.design.jump.robot:
        return ""
    waits = foreign.ticket or state.repairing or state.planning or not state.ready
    return "waits" if waits else "ready"


@on(RepairAsked)
def repair(state: TabState, _: RepairAsked) -> Step:
    """Repair the motion that is open; one that was repaired already is shown again."""
    foreign = state.foreign
    if foreign is None or offer(state) != "ready":
        return state, ()
    if foreign.plan is not None:
        return _show(state, foreign.plan)
    state = replace(state, foreign=replace(foreign, progress=""))
    state = state.with_status(Verdict.PLANNING, "a repair ...", busy=True)
    return submit(state, tasks.RepairMotion(_states(foreign.motion)))


@on(tasks.RepairMotion)
def take_repair(state: TabState, event: Reported) -> Step:
    """The motion is being repaired, or has been, or cannot be."""
    foreign, report = state.foreign, event.report
    match report:
        case reports.Progress(text=text, iteration=iteration, lasts=lasts):
            line = summaries.progress_line(text, iteration)
            if foreign is not None:
                state = replace(state, foreign=replace(foreign, progress=line))
            return state.with_status(
                Verdict.PLANNING, f"a repair {line}", busy=True, lasts=lasts
            ), ()
        case reports.Repaired(repair=found) if foreign is not None:
            return _take(state, foreign, found)
        case reports.Repaired():  # it was unpinned meanwhile
            report = reports.Cancelled(0)
    return ended(state, report, _KEPT), ()


def _take(state: TabState, foreign: Foreign, found: Repair) -> Step:
    """The repair is there: the motion before stands beside its plan, cut to what was repaired."""
    name, before = foreign.motion.name, foreign.motion
    if found.plan is not None:
        try:
            dump_design(Design(found.plan.jump, found.plan.tuning))  # as it is kept and shared
        except Error as error:
            found = replace(found, status=FAILED, why=f"{error}.")
    foreign = replace(foreign, repair=found, before=found.before)
    plan = foreign.plan
    if plan is None:
        state = replace(state, foreign=foreign)
        return ended(state, reports.Failed(0, f"{name} was not repaired. {found.why}"), _KEPT), ()
    part = bake_foreign(name, motion_before(before.motion, found))
    pins = tuple(replace(pin, motion=part) if pin.motion is before else pin for pin in state.pins)
    state = replace(state, foreign=replace(foreign, motion=part), pins=pins)
    return _show(state, plan)


def _show(state: TabState, plan: Plan) -> Step:
    """Make a repaired motion the page's plan, beside what it was."""
    robot, foreign = state.robot, state.foreign
    if robot is None or foreign is None:
        return state, ()
    design = Design(plan.jump, plan.tuning, state.design.scenario)
    state = remember(state, design, settled=True)
    note = f"Repaired from {foreign.motion.name}."
    state = replace(state, comparing=None, beside=True, note=note)
    state = show_plan(state, plan, robot)
    assert state.shown is not None
    return also(show_again(state, state.shown), Seek(0.0), Play())
