"""The draft of a motion that was there already, such as the one with which a page opens.

It is made once the motion has been shown for a while, so that the first step of a slider begins
from it; from scratch that one takes three times as long as those that follow.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from app.tab.acts import Step, also, on, submit_beside
from app.tab.effects import After, Queue
from app.tab.state import TabState
from app.workers import reports, tasks
from llsrbm.motion.plan import Plan

LATER = 1.5
"""s after a motion is shown: its first pictures come first."""


@dataclass(frozen=True, eq=False)
class Lasted:
    """A motion has been shown for a while."""

    plan: Plan


def draft_later(step: Step) -> Step:
    """A step that shows a motion, whose draft is made later."""
    plan = step[0].plan
    return also(step, After(LATER, Lasted(plan))) if plan and _lacks_draft(step[0]) else step


@on(Lasted)
def begin(state: TabState, event: Lasted) -> Step:
    """Have its draft made, unless something else is shown or under way by now."""
    if state.plan is not event.plan or state.planning or not _lacks_draft(state):
        return state, ()
    task = tasks.PlanJump(event.plan.jump, event.plan.tuning, alone=True)
    return submit_beside(state, Queue.BEGINNING, task)


def take_draft(state: TabState, report: reports.Report) -> TabState:
    """The draft is kept beside its plan, if that is still shown; all goes on without one, too."""
    shown, plan = state.shown, state.plan
    if not isinstance(report, reports.Planned) or shown is None or plan is None:
        return state
    draft, same = report.plan, plan.jump == report.plan.jump and plan.tuning == report.plan.tuning
    if not same or not _lacks_draft(state):
        return state
    return replace(state, shown=replace(shown, centroidal=draft))


def _lacks_draft(state: TabState) -> bool:
    shown, plan = state.shown, state.plan
    if shown is None or plan is None or not state.whole_body or not state.ready:
        return False
    # Routes begin from plans of their jumps; bodies that turn over stay drafts.
    plain = not plan.jump.route and not plan.jump.turns
    return plain and plan.refined and shown.centroidal is None and not shown.source
