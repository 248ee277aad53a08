"""The robot simulator: the player plays the plan through what a robot's own wire does to it."""

from app.panel.acts import Act
from app.panel.status import Verdict
from app.tab.acts import Step, on, submit
from app.tab.comparison import pin
from app.tab.effects import Notify
from app.tab.state import TabState, free_colour
from app.workers.tasks import SimulateJump


def _can_be_played(state: TabState) -> bool:
    shown = state.plan is not None and state.plan.solved
    return shown and state.ready and not state.planning


@on(Act.ROBOT_SIMULATOR, enabled=_can_be_played)
def play_through_wire(state: TabState) -> Step:
    """Play the plan through a robot's wire; the direct simulation that is shown is pinned."""
    plan, scenario = state.plan, state.design.scenario
    if plan is None or not _can_be_played(state):
        return state, (Notify("Not played", "There is no plan yet."),)
    if scenario.pushes:
        words = "The robot simulator knows no pushes; expected a scenario without any."
        return state, (Notify("Not played", words),)
    if state.rollout is not None and not state.outdated and free_colour(state.pins) is not None:
        state = pin(state)
    state = state.with_status(Verdict.SIMULATING, "through the wire ...", busy=True)
    return submit(state, SimulateJump(plan, scenario, wire=True))
