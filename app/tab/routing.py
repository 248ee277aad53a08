"""Routes: landings clicked one after the other in the picture, added, moved and taken away."""

import math
from dataclasses import replace

from app.panel.acts import Act
from app.panel.route_controls import ChosenLanding
from app.picture.ground_clicks import GroundClicked
from app.tab.acts import Step, also, on, reads
from app.tab.design import choose_jump
from app.tab.effects import Notify
from app.tab.state import TabState
from llsrbm.errors import InputError
from llsrbm.request.jump import Jump
from llsrbm.request.route import MOST, START, Landing, Waypoint, through, waypoints

DRAWING = "Click the ground where the robot shall land next"
"""The remark on the picture meanwhile."""

_THERE = 0.05  # m from a landing: a click there is on its handle
_ONWARDS = 0.5  # of the usual farthest jump forward: a landing that is added by its button


reads(Act.ROUTE, lambda state, panel: panel.route.fields.read(state.chosen_landing, None))


@on(ChosenLanding)
def choose_landing(state: TabState, chosen: ChosenLanding) -> Step:
    """Show the numbers of a landing, or plan with others."""
    if chosen.number != state.landing:  # its numbers are a step of their own
        state = replace(state, history=replace(state.history, changing=()), landing=chosen.number)
    return (state, ()) if chosen.jump == state.design.jump else choose_jump(state, chosen.jump)


def _may_have_route(state: TabState) -> bool:
    return state.ready and not state.design.jump.turns


def _may_grow(state: TabState) -> bool:
    return _may_have_route(state) and state.design.jump.jumps < MOST


def _has_route(state: TabState) -> bool:
    return bool(state.design.jump.route)


def _draws(state: TabState) -> bool:
    return state.drawing is not None


@on(
    Act.DRAW_ROUTE,
    enabled=lambda state: _may_have_route(state) and (_may_grow(state) or not _has_route(state)),
    visible=lambda state: not _draws(state),
)
def draw_route(state: TabState) -> TabState:
    """Have clicks on the ground be landings; the first one of a jump that is no route yet."""
    return replace(state, drawing=state.design.jump)


@on(Act.STOP_DRAWING, visible=_draws)
def stop_drawing(state: TabState) -> TabState:
    """Have clicks in the picture be what they were."""
    return replace(state, drawing=None)


@on(GroundClicked)
def click_ground(state: TabState, click: GroundClicked) -> Step:
    """Have the robot land there next, as it stands before."""
    jump = state.design.jump
    if state.drawing is None or not _may_have_route(state):
        return state, ()
    begins = jump == state.drawing and not jump.route
    places = () if begins else waypoints(jump.landings)
    ground = min(place.z for place in (START, *places))
    at = click.meets(ground)
    if at is None:
        return state, ()
    if any(math.dist(at, place[:2]) < _THERE for place in places):
        return state, ()
    heading = places[-1].heading if places else 0.0
    there = Waypoint(round(at[0], 2), round(at[1], 2), ground, heading)
    step = _along(state, through((*places, there), () if begins else jump.landings))
    return _ended_when_full(step)


@on(Act.ADD_LANDING, enabled=_may_grow)
def add_landing(state: TabState) -> Step:
    """Have the robot jump on from its last landing, straight ahead."""
    onwards = round(_ONWARDS * state.file.task.forward[1], 2)
    landings = (*state.design.jump.landings, Landing(forward=onwards))
    return _ended_when_full(_along(state, landings))


@on(Act.REMOVE_LANDING, enabled=_has_route)
def remove_landing(state: TabState) -> Step:
    """Have the route without the landing that is shown; the others stay where they are."""
    route, number = state.design.jump.route, state.chosen_landing.number
    if not route:
        return state, ()
    kept = [k for k in range(len(route)) if k != number]
    places = waypoints(route)
    return _along(state, through([places[k] for k in kept], [route[k] for k in kept]))


@on(Act.REMOVE_ROUTE, enabled=_has_route)
def remove_route(state: TabState) -> Step:
    """Have the route's first jump alone."""
    return _along(replace(state, drawing=None), state.design.jump.landings[:1])


def _along(state: TabState, landings: tuple[Landing, ...]) -> Step:
    """Plan another route, which is one step back."""
    try:
        jump: Jump = state.design.jump.along(landings)
    except InputError as error:  # a landing is too far away
        return also((state, ()), Notify("No landing there", str(error)))
    state = replace(state, history=replace(state.history, changing=()))
    grows = jump.jumps > state.design.jump.jumps
    state = replace(state, landing=jump.jumps - 1 if grows else state.landing)
    state, effects = choose_jump(state, jump)
    return replace(state, history=replace(state.history, changing=())), effects


def _ended_when_full(step: Step) -> Step:
    state, effects = step
    if state.drawing is not None and state.design.jump.jumps >= MOST:
        state = replace(state, drawing=None)
    return state, effects
