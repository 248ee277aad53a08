"""Questions about the motion that is shown: what a part of the robot does, and its certificate."""

from dataclasses import replace

from app.link import CertificateAsked, PartAsked, PartPlotted
from app.panel.acts import Act
from app.plots.charts import shown_layers
from app.plots.readings import reading, rows_of
from app.tab.acts import Step, on, submit_beside
from app.tab.effects import Queue, Reported, ShowPart
from app.tab.plotting import choose_plots
from app.tab.state import Check, TabState
from app.workers import reports, tasks
from llsrbm.certificate import stated
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout

# ---- parts of the robot


@on(PartAsked)
def read_part(state: TabState, event: PartAsked) -> Step:
    """Say what a part does over the whole motion."""
    shown, robot = state.seen, state.robot
    if shown is None or robot is None or not state.ready:
        return state, ()
    layers = shown_layers(shown.planned, shown.rollout)
    return state, (ShowPart(reading(event.part, robot, layers)),)


@on(PartPlotted)
def plot_part(state: TabState, event: PartPlotted) -> TabState:
    """Have a row of a part as a chart too."""
    if state.robot is None:
        return state
    charts = [*rows_of(event.part, state.robot).values()]
    if event.row >= len(charts):
        return state
    offered = state.plots_seen.offered
    plots = replace(state.plots_seen, offered=charts[event.row], open=True).with_offered()
    return choose_plots(state, replace(plots, offered=offered))


# ---- the certificate: it takes a second, and is made when it is asked for


def _can_be_checked(state: TabState) -> bool:
    motion = state.motion
    checked = state.check is not None and state.check.motion is motion
    return motion is not None and state.plan is not None and state.plan.solved and not checked


@on(Act.CHECK, CertificateAsked, enabled=_can_be_checked)
def check(state: TabState, _: CertificateAsked | None = None) -> Step:
    """Check the simulation that is shown, else the plan; once."""
    motion = state.motion
    if motion is None or not _can_be_checked(state):
        return state, ()
    known = stated(motion)
    if known is not None:  # of a file
        return replace(state, check=Check(motion, certificate=known)), ()
    return begin_check(state, motion)


def begin_check(state: TabState, motion: Plan | Rollout) -> Step:
    """Have a motion checked."""
    state, effects = submit_beside(state, Queue.CHECK, tasks.CheckMotion(motion))
    return replace(state, check=Check(motion, state.tickets, note="Checking ...")), effects


@on(tasks.CheckMotion)
def take_check(state: TabState, event: Reported) -> TabState:
    """The motion is being checked, or has been."""
    check = state.check
    if check is None or event.ticket != check.ticket:
        return state
    match event.report:
        case reports.Checked(certificate=certificate):
            return replace(state, check=Check(check.motion, certificate=certificate))
        case reports.Failed(message=message):
            return replace(state, check=Check(check.motion, note=f"Not checked: {message}"))
        case reports.Cancelled():
            return replace(state, check=None)
    return state
