"""The robot of a design: prepared, loaded and drawn before anything is planned for it."""

from dataclasses import replace

from app.panel import summaries
from app.panel.status import Verdict
from app.tab.acts import Step, joined, on, submit_beside
from app.tab.effects import LoadRobot, Notify, Queue, Reported, RobotLoaded, RobotMissing
from app.tab.planning.refining import show_given_refined
from app.tab.planning.requests import PLAN_AGAIN, plan_design
from app.tab.showing import ended
from app.tab.state import TabState
from app.workers import reports, tasks


@on(tasks.Prepare)
def take_prepared(state: TabState, event: Reported) -> Step:
    """The design's robot can be loaded, or is being prepared; or its meshes have been made."""
    if event.job.queue is Queue.ROBOT:
        return _take_meshes(state, event.report)
    match report := event.report:
        case reports.Progress():
            line = summaries.progress_line(report.text, None)
            line = f"{state.work.instead}{line}"
            return state.with_status(Verdict.PLANNING, line, busy=True), ()
        case reports.Prepared(robot=robot):
            return state, (LoadRobot(robot),)
        case reports.Failed():
            return ended(state, report, PLAN_AGAIN), ()
    return ended(state.forgetting(), report, PLAN_AGAIN), ()


def _take_meshes(state: TabState, report: reports.Report) -> Step:
    """The meshes of a robot that is drawn by its collision shapes have been made."""
    match report:
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
        return joined(effects, show_given_refined(state, given))
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
    state = replace(state, shown=None, seeds=None, far=None)
    if event.prepared:
        return state, ()
    return submit_beside(state, Queue.ROBOT, tasks.Prepare(event.robot.name))
