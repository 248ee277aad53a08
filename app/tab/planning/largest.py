"""How far?: the largest jump along a slider, searched for beside all else, and taken."""

from dataclasses import replace
from functools import partial

from app.panel.acts import HOW_FAR, Act
from app.tab.acts import Step, on, submit_beside
from app.tab.effects import Queue, Reported
from app.tab.how_far import HowFar, direction_of
from app.tab.planning.feasible import learn
from app.tab.planning.known import show_again
from app.tab.planning.requests import remember, untitled
from app.tab.showing import show_plan
from app.tab.state import TabState
from app.workers import reports, tasks
from llsrbm.request.jump import Jump


def _can_be_searched(state: TabState) -> bool:
    return state.ready and not state.design.jump.turns


def search_along(state: TabState, component: str) -> Step:
    """Look for the largest jump towards the side to which the slider stands."""
    if not _can_be_searched(state):
        return state, ()
    jump, tuning = state.design.jump, state.design.tuning
    return search(state, HowFar(direction_of(component, getattr(jump, component)), jump, tuning))


for _component, _act in HOW_FAR.items():
    on(_act, enabled=_can_be_searched)(partial(search_along, component=_component))


def search(state: TabState, far: HowFar) -> Step:
    """Have it looked for, in place of the one before."""
    task = tasks.FindLargest(far.jump, far.tuning, far.towards)
    state, effects = submit_beside(state, Queue.LARGEST, task)
    return replace(state, far=replace(far, ticket=state.tickets)), effects


@on(tasks.FindLargest)
def take_report(state: TabState, event: Reported) -> TabState:
    """It is being looked for, or has been found, or there is none."""
    far, report = state.far, event.report
    if far is None or event.ticket != far.ticket:
        return state
    match report:
        case reports.Progress(text=text):
            return replace(state, far=replace(far, note=text))
        case reports.FoundLargest(largest=found):
            state = learn(state, report, event.job.task).reaching(found.plan.jump)
            return replace(state, far=replace(far, ticket=0, found=found))
        case reports.Refused(reason=why) | reports.Failed(message=why):
            return replace(state, far=replace(far, ticket=0, why_not=why.removesuffix(".")))
    return replace(state, far=None)  # it was cancelled


def _offered(state: TabState) -> Jump | None:
    """The jump that can be taken: it was found, holds for the design, and is not asked for yet."""
    far = state.far
    if far is None or far.found is None or not state.ready or not far.answers(state.design):
        return None
    jump = far.found.plan.jump
    return None if jump == state.design.jump else jump


@on(Act.USE_LARGEST, visible=lambda state: _offered(state) is not None)
def take_largest(state: TabState) -> Step:
    """Ask for the largest jump, and show its plan, which is there."""
    jump, far, robot = _offered(state), state.far, state.robot
    if jump is None or far is None or far.found is None or robot is None:
        return state, ()
    state, design = untitled(state, jump, state.design.tuning)
    state = show_plan(remember(state, design, settled=True), far.found.plan, robot)
    assert state.shown is not None
    return show_again(state, state.shown)
