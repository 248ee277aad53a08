"""Edges and apex of the timeline: dragged, they become limits of the plan."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from app.link import ApexDragged, PhasesDragged
from app.tab.acts import Step, on
from app.tab.design import choose_tuning
from app.tab.state import TabState
from llsrbm.motion.plan import Plan
from llsrbm.planning.problem.apex import Flight
from llsrbm.planning.problem.placement import limits_of
from llsrbm.request.jump_types import load_type
from llsrbm.request.tuning import Tuning
from llsrbm.robots import Robot

TIME_ROOM = 6e-4  # s that a phase may be shorter or longer than where its edges were put
HEIGHT_ROOM = 1.5e-3  # m likewise, of the apex
_LEAST_RISE, _LONGEST = 0.02, 0.8  # m above lift-off, s of a flight, that an apex may be dragged to


@dataclass(frozen=True)
class Edge:
    """Where a phase ends, and where it may be dragged to, s; `phases` keep their durations then."""

    name: str
    time: float
    low: float
    high: float
    phases: int


@dataclass(frozen=True)
class Apex:
    """The highest place of the CoM, when it is there, and which heights it may be dragged to, m."""

    name: str
    time: float
    height: float
    low: float
    high: float


@dataclass(frozen=True)
class Handles:
    """Everything that can be dragged in a timeline; starts: s, of the phases, and the end.

    The page's script reads all of it (app/static/shaping.js).
    """

    starts: tuple[float, ...]
    edges: tuple[Edge, ...]
    apex: Apex | None

    def plain(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


# ---- what can be dragged


def handles_of(state: TabState) -> Handles | None:
    """Handles of the plan that is shown; None: it is not of the design, or of several."""
    shown, design, robot = state.shown, state.design, state.robot
    if shown is None or robot is None or not state.ready or state.comparing is not None:
        return None
    plan = shown.plan
    if (plan.jump.robot, plan.jump.type) != (design.jump.robot, design.jump.type):
        return None
    return Handles(tuple(plan.phase_start.tolist()), _edges(plan, robot), _apex(plan))


def _edges(plan: Plan, robot: Robot) -> tuple[Edge, ...]:
    """Ends of the first phases, up to one whose duration is no limit of a request."""
    names, starts, ranges = timings(plan), plan.phase_start.tolist(), _ranges(robot)
    found = []
    for p, name in enumerate(names):
        shortest, longest = ranges[name]
        low, high = starts[p] + shortest, starts[p] + longest
        following = p + 1 < len(names)
        if following:
            shortest, longest = ranges[names[p + 1]]
            low, high = max(low, starts[p + 2] - longest), min(high, starts[p + 2] - shortest)
        kept = p + 1 + following
        found.append(Edge(f"End of {plan.schedule[p].name}", starts[p + 1], low, high, kept))
    return tuple(found)


def timings(plan: Plan) -> list[str]:
    """Rows of the robot file's timing that the first phases of a plan take as long as."""
    found: list[str] = []
    for phase in plan.schedule:
        if not isinstance(phase.time, str):
            break
        found.append(phase.time)
    return found


@lru_cache(maxsize=4)
def _ranges(robot: Robot) -> Mapping[str, tuple[float, float]]:
    """Durations of phases, and heights of the apex, that limits may ask for: s and m."""
    limits = {name: limit for name, (limit, _) in limits_of(robot).items()}
    found = {}
    for name in ("takeoff", "flight", "landing", "apex"):
        least, most = limits[f"{name}_min"], limits[f"{name}_max"]
        found[name] = max(least.lowest, most.lowest), min(least.highest, most.highest)
    return found


def _apex(plan: Plan) -> Apex | None:
    """The highest place in the first flight."""
    if not plan.schedule.flights:
        return None
    flight, begins = first_flight(plan), float(plan.phase_start[plan.schedule.flights[0]])
    low = max(flight.before, flight.after) + _LEAST_RISE
    high = flight._replace(time=_LONGEST).apex
    height = flight.apex
    return Apex("Apex", begins + flight.rising, height, min(low, height), max(high, height))


def first_flight(plan: Plan) -> Flight:
    """The CoM's heights at its ends, and its duration."""
    phase = plan.schedule.flights[0]
    begins, ends = plan.phase_start[[phase, phase + 1]].tolist()
    before, after = np.interp([begins, ends], plan.time, plan.com[:, 2]).tolist()
    return Flight(before, after, ends - begins)


# ---- what comes of it


@on(PhasesDragged)
def drag_edge(state: TabState, event: PhasesDragged) -> Step:
    """Have the first phases last as long as where their edges were dragged to, or as they like."""
    plan, robot = state.plan, state.robot
    if plan is None or robot is None or handles_of(state) is None:
        return state, ()
    limits, names = dict(state.design.tuning.limits), timings(plan)
    for name in names if not event.durations else ():
        _release(limits, name)
    for name, duration in zip(names, event.durations, strict=False):
        if name == "flight":
            _release(limits, "apex")  # both say how long it takes
        _pin(limits, name, duration, TIME_ROOM, robot)
    return _planned(state, limits, begins=event.begins)


@on(ApexDragged)
def drag_apex(state: TabState, event: ApexDragged) -> Step:
    """Have flights rise as high as where the apex was dragged to, or as high as they like."""
    plan, robot, handles = state.plan, state.robot, handles_of(state)
    if plan is None or robot is None or handles is None or handles.apex is None:
        return state, ()
    limits = dict(state.design.tuning.limits)
    _release(limits, "flight")
    if event.height is None:
        _release(limits, "apex")
        return _planned(state, limits, begins=event.begins)
    height = min(max(event.height, handles.apex.low), handles.apex.high)
    _pin(limits, "apex", height, HEIGHT_ROOM, robot)
    # Flights that have to be shorter or longer than the robot's own may be.
    time = first_flight(plan).time_to(height)
    own = {name: value for name, (_, value) in limits_of(robot).items()}
    own |= load_type(plan.jump.type).limits
    shortest, longest = _ranges(robot)["flight"]
    if time < own["flight_min"]:
        limits["flight_min"] = shortest
    if time > own["flight_max"]:
        limits["flight_max"] = longest
    return _planned(state, limits, begins=event.begins)


def _release(limits: dict[str, float], name: str) -> None:
    for end in ("min", "max"):
        limits.pop(f"{name}_{end}", None)


def _pin(limits: dict[str, float], name: str, value: float, room: float, robot: Robot) -> None:
    """Bound something to a value from both sides, within its range; where it is there, it stays."""
    low, high = _ranges(robot)[name]
    value = round(min(max(value, low), high), 3)
    least, most = limits.get(f"{name}_min", -np.inf), limits.get(f"{name}_max", np.inf)
    if most - least < 3 * room and abs(value - (least + most) / 2) <= room:
        return
    limits[f"{name}_min"], limits[f"{name}_max"] = round(value - room, 4), round(value + room, 4)


def _planned(state: TabState, limits: dict[str, float], *, begins: bool) -> Step:
    """Plan under other limits; all that follows what `begins` is one step back with it."""
    changing = () if begins else ("Tuning.limits",)
    state = replace(state, history=replace(state.history, changing=changing))
    return choose_tuning(state, Tuning(state.design.tuning.weights, limits))
