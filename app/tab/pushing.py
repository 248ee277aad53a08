"""A push: drawn in the picture or entered in the panel, simulated when it is let go of."""

import math
from dataclasses import replace

import numpy as np

from app.link import PushDragged
from app.motion.baked import metres_per_newton_second, trunk_com
from app.panel.acts import Act
from app.picture.push_handle import PushShown
from app.tab.acts import Step, joined, kept, on, reads
from app.tab.effects import Pause, Seek
from app.tab.planning.requests import remember
from app.tab.simulating import simulate, simulate_again
from app.tab.state import TabState
from app.workers.tasks import SimulateJump, SimulateSeeds
from llsrbm.request.scenario import DURATION, LARGEST_IMPULSE, Push, Scenario

USUAL_SPEED = 0.3  # m/s that a push gives the robot, to begin with: seen, and survived

_LEAST = 0.05  # N s; a smaller push is a click that nobody dragged
_DECIMALS = 1  # of a dragged impulse, N s


reads(
    Act.SCENARIO, lambda state, panel: panel.scenario.fields.read(state.design.scenario, state.file)
)


@on(Scenario)
def choose_scenario(state: TabState, scenario: Scenario) -> Step:
    """Simulate in another scenario from now on; a push that is new begins where the page stands."""
    before = state.design.scenario
    if before.seed is not None and scenario.seed is None:
        state = replace(state, noise=before.noise)
    elif before.seed is None and scenario.seed is not None and state.noise is not None:
        scenario = replace(scenario, noise=state.noise)  # disturbed again, as much as before
    if not scenario.pushes or (before.pushes and before.pushes[0].time == scenario.pushes[0].time):
        state, effects = kept(remember(state, replace(state.design, scenario=scenario)))
        return joined(effects, simulate_again(state))
    first, *others = scenario.pushes
    if not before.pushes:
        first = _first_push(state, first)
    scenario = replace(scenario, pushes=(first, *others))
    state, effects = kept(remember(state, replace(state.design, scenario=scenario)))
    state = replace(state, history=replace(state.history, changing=()))
    if state.shown is None:
        return state, effects
    return state, (*effects, Pause(), Seek(first.time))


@on(PushDragged)
def drag_push(state: TabState, event: PushDragged) -> Step:
    """Have the push that is drawn; simulate it when it is let go of.

    A push that begins at that instant is changed, and keeps its vertical part.
    """
    scenario, shown, robot = state.design.scenario, state.shown, state.robot
    if shown is None or robot is None or not state.ready or not shown.plan.solved:
        return state, ()
    first, *others = scenario.pushes or (None,)
    time, z = min(event.time, (shown.solid or shown.planned.frames).end), 0.0
    if first is not None and abs(first.time - time) <= DURATION:
        time, z = first.time, first.impulse[2]
    scale = metres_per_newton_second(robot)
    impulse = event.x / scale, event.y / scale, z
    size = math.hypot(*impulse)
    if size < _LEAST:
        return state, ()
    # Rounded towards zero, a push of the largest size stays one.
    share = min(1.0, LARGEST_IMPULSE / size)
    x, y, z = (_truncated(share * value) for value in impulse)
    push = Push(time, (x, y, z), first.moment if first else (0.0, 0.0, 0.0))
    scenario = replace(scenario, pushes=(push, *others))
    state = remember(state, replace(state.design, scenario=scenario))
    if not event.ended:
        return state, ()
    state = replace(state, history=replace(state.history, changing=()))
    state, effects = simulate(state)
    return state.with_work(replay_from=replay_start(state)), effects


def _truncated(value: float) -> float:
    """With so many decimals; what falls short of one by a rounding error has it."""
    return math.trunc(round(value * 10**_DECIMALS, 6)) / 10**_DECIMALS


def replay_start(state: TabState) -> float:
    """From where a simulation of the design is played, s: it goes on where the push was drawn."""
    pushes = state.design.scenario.pushes
    return pushes[0].time if pushes else 0.0


def push_shown(state: TabState) -> PushShown | None:
    """The push as it is drawn to be dragged; None: there is none, or something moves."""
    shown, robot, pushes = state.shown, state.robot, state.design.scenario.pushes
    if not pushes or shown is None or robot is None or not state.ready or not shown.plan.solved:
        return None
    if state.playback.playing or isinstance(state.work.awaited, SimulateJump | SimulateSeeds):
        return None
    frames = shown.solid or shown.planned.frames
    time = min(state.playback.time, frames.end)
    at = [float(np.interp(time, frames.time, axis)) for axis in trunk_com(robot, frames).T]
    push = pushes[0]
    begins = abs(push.time - time) <= DURATION
    return PushShown(
        time=push.time if begins else time,
        origin=(at[0], at[1], at[2]),
        impulse=push.impulse if begins else (0.0, 0.0, 0.0),
        metres_per_newton_second=metres_per_newton_second(robot),
    )


def _first_push(state: TabState, push: Push) -> Push:
    """A push at the instant that is shown, of the usual size if none was entered."""
    time, plan, robot = state.playback.time, state.plan, state.robot
    if plan is not None and (state.playback.playing or not 0 < time <= plan.duration):
        # Nobody points at an instant of a motion that runs: in the middle of the first flight.
        flight = plan.schedule.flights[0]
        time = float(plan.phase_start[flight : flight + 2].mean())
    impulse = push.impulse
    if not any(impulse) and robot is not None:
        impulse = (0.0, float(round(USUAL_SPEED * robot.mass)), 0.0)
    return Push(round(time, 3), impulse, push.moment)
