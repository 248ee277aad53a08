"""The certificate of the motion that is shown, made when it is asked for: it takes a second."""

from __future__ import annotations

from dataclasses import replace

from app.link import CertificateAsked
from app.panel.acts import Act
from app.tab.acts import Step, on, submit_beside
from app.tab.effects import Queue, Reported
from app.tab.state import Check, TabState
from app.workers import reports, tasks
from llsrbm.certificate import stated


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
        return replace(state, check=Check(motion, 0, known)), ()
    state, effects = submit_beside(state, Queue.CHECK, tasks.CheckMotion(motion))
    return replace(state, check=Check(motion, state.tickets, note="Checking ...")), effects


@on(Queue.CHECK)
def take_check(state: TabState, event: Reported) -> TabState:
    """The motion is being checked, or has been."""
    if state.check is None or event.ticket != state.check.ticket:
        return state
    match event.report:
        case reports.Checked(certificate=certificate):
            return replace(state, check=replace(state.check, certificate=certificate, note=""))
        case reports.Failed(message=message):
            return replace(state, check=replace(state.check, note=f"Not checked: {message}"))
        case reports.Cancelled():
            return replace(state, check=None)
    return state
