"""The timeline of a motion: its phases as strips, and what happens when."""

import math
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from llsrbm.arrays import stretches
from llsrbm.look import palette
from llsrbm.look.palette import Rgb
from llsrbm.motion.flights import Flight, flights
from llsrbm.motion.plan import Plan
from llsrbm.motion.replan import DEADLINE, Replan
from llsrbm.motion.rollout import Mode, Rollout
from llsrbm.number_text import decimal
from llsrbm.request.schedule import Schedule

_STANDING = "standing"
_PALER = 0.6  # of the way to white, of a phase in which hardly a foot stands


@dataclass(frozen=True)
class Piece:
    """A stretch of a strip: what it is called, from `start` to `end`, s.

    `low` ones lie in the lower half, over others. `feet` are those that stand, in words, where it
    is a phase.
    """

    name: str
    start: float
    end: float
    colour: Rgb
    low: bool = False
    feet: str = ""


@dataclass(frozen=True)
class Strip:
    """One strip."""

    name: str
    colour: Rgb
    pieces: tuple[Piece, ...]


@dataclass(frozen=True)
class Mark:
    """An instant, s, with a name."""

    name: str
    time: float
    colour: Rgb


@dataclass(frozen=True)
class Bar:
    """Computing time of a replan of the state that was measured at `time`, s.

    `height` is the computing time over its deadline. `in_time`: a solution within it.
    """

    time: float
    height: float
    in_time: bool
    words: str


@dataclass(frozen=True)
class Timeline:
    """Phases and events over time.

    Attributes:
        rows: strips, the last one is of what is drawn solid.
        marks: in order of time; summary: the events in one line.
        end: s.
        bars: computing times of what was planned anew.
    """

    rows: tuple[Strip, ...]
    marks: tuple[Mark, ...]
    summary: str
    end: float
    bars: tuple[Bar, ...] = ()

    def plain(self) -> dict[str, Any]:
        """For JSON; colours as style sheets have them."""
        plain = asdict(self)
        pieces = (piece for row in plain["rows"] for piece in row["pieces"])
        for each in (*plain["rows"], *pieces, *plain["marks"]):
            each["colour"] = palette.css(each["colour"])
        return plain


def timeline(plan: Plan, rollout: Rollout | None = None) -> Timeline:
    """Phases and events of a plan, and of the simulation that followed it, if any."""
    marks: list[Mark] = _planned_marks(plan)
    bars: tuple[Bar, ...] = ()
    if rollout is None:
        end, events = plan.duration, _planned_events(plan)
        rows = [_planned(plan, end)]
    else:
        end, events = max(plan.duration, float(rollout.time[-1])), _events(rollout)
        simulated = _simulated(rollout, plan.duration)
        rows = [_planned(plan, end), Strip("simulation", palette.SIMULATED, simulated)]
        marks += _simulated_marks(rollout)
        followed = [r.measured for r in rollout.replans if not math.isnan(r.applied)]
        bars = tuple(_bar(replan, min(followed, default=math.inf)) for replan in rollout.replans)
    marks.sort(key=lambda mark: mark.time)
    return Timeline(tuple(rows), tuple(marks), events, end, bars)


def phase_at(events: Timeline, time: float) -> str:
    """The phase of what is drawn solid."""
    pieces = [piece for piece in events.rows[-1].pieces if not piece.low]
    return next((p.name for p in pieces if p.start <= time < p.end), pieces[-1].name)


def phase_colour(schedule: Schedule, phase: int) -> Rgb:
    """Colour of a phase: take-off, flight, landing, or in between; paler with fewer feet."""
    if schedule[phase].is_flight:
        return palette.FLIGHT
    first, last = schedule.flights[0], schedule.flights[-1]
    colour = palette.REBOUND
    if phase < first:
        colour = palette.TAKE_OFF
    elif phase > last:
        colour = palette.LANDING
    raised = 1.0 - float(schedule.stands[phase].mean())
    return palette.paler(colour, _PALER * raised)


def _piece(schedule: Schedule, phase: int, start: float, end: float) -> Piece:
    feet = schedule.standing_words(phase)
    return Piece(schedule[phase].name, start, end, phase_colour(schedule, phase), feet=feet)


def _simulated(rollout: Rollout, planned_end: float) -> tuple[Piece, ...]:
    """The controller's phases, and in them where it tracks forces."""
    time, phase = rollout.time, rollout.phase
    changes = (np.flatnonzero(np.diff(phase)) + 1).tolist()
    edges = [float(time[tick]) for tick in (0, *changes, -1)]
    pieces = [
        _piece(rollout.schedule, int(phase[tick]), a, min(b, planned_end))
        for a, b, tick in zip(edges[:-1], edges[1:], (0, *changes), strict=True)
        if a < planned_end
    ]
    if edges[-1] > planned_end:
        pieces.append(_standing(planned_end, edges[-1]))
    forces = [
        Piece("force control", a, b, palette.FORCE, low=True) for a, b in force_phases(rollout)
    ]
    return (*pieces, *forces)


def _planned(plan: Plan, end: float) -> Strip:
    edges = enumerate(pairwise(plan.phase_start.tolist()))
    pieces = [_piece(plan.schedule, phase, a, b) for phase, (a, b) in edges]
    if end > plan.duration:
        pieces.append(_standing(plan.duration, end))
    return Strip("plan", palette.PLANNED, tuple(pieces))


def _standing(start: float, end: float) -> Piece:
    return Piece(_STANDING, start, end, palette.STANDING, feet="all feet")


def _planned_marks(plan: Plan) -> list[Mark]:
    marks, landed = [], 0.0
    for number, phase in enumerate(plan.schedule.flights, start=1):
        flight = np.flatnonzero(plan.phase == phase)
        apex = flight[np.argmax(plan.com[flight, 2])]
        before = np.flatnonzero((plan.time >= landed) & (plan.time <= plan.phase_start[phase]))
        lowest = before[np.argmin(plan.com[before, 2])]
        landed = plan.phase_start[phase + 1]
        instants = {
            "push-off": plan.time[lowest],  # from where the CoM is moved up
            "lift-off": plan.phase_start[phase],
            "apex": plan.time[apex],
            "touchdown": landed,
        }
        marks += [
            Mark(_numbered(name, number), float(time), palette.PLANNED)
            for name, time in instants.items()
        ]
    return marks


def _simulated_marks(rollout: Rollout) -> list[Mark]:
    marks = [
        Mark(_numbered(name, number), time, palette.SIMULATED)
        for number, flight in enumerate(flights(rollout), start=1)
        for name, time in (("first contact", flight.touchdown), ("detected", flight.detected))
        if time is not None
    ]
    marks += _pushes(rollout)
    if not rollout.landed:
        at = rollout.outcome.fell_at_s
        time = float(rollout.time[-1]) if at is None else at
        marks.append(Mark("fell", time, palette.INFEASIBLE))
    return marks


def _pushes(rollout: Rollout) -> list[Mark]:
    return [
        Mark(f"push {math.hypot(*push.impulse):.3g} N s", push.time, palette.FORCE)
        for push in rollout.pushes
    ]


def _bar(replan: Replan, first: float) -> Bar:
    """`first`: s, when the first one that was followed was begun; before, none need be."""
    took = f"{1e3 * replan.computing_time:.1f} ms of {1e3 * DEADLINE:g} ms"
    if not replan.solved:
        took += ", no solution"
    elif math.isnan(replan.applied):
        took += ", not followed" if replan.measured < first else ", too late to be followed"
    in_time = replan.solved and replan.computing_time <= DEADLINE
    words = f"planned anew at {replan.measured:.3f} s: {took}"
    return Bar(replan.measured, replan.computing_time / DEADLINE, in_time, words)


def _numbered(name: str, number: int) -> str:
    return name if number == 1 else f"{name} {number}"


def _planned_events(plan: Plan) -> str:
    starts = plan.phase_start
    return ", ".join(
        f"{_numbered('lift-off', number)} {starts[phase]:.2f} s, "
        f"{_numbered('touchdown', number)} {starts[phase + 1]:.2f} s"
        for number, phase in enumerate(plan.schedule.flights, start=1)
    )


def _events(rollout: Rollout) -> str:
    parts = []
    for number, (planned, flight) in enumerate(_planned_and_flown(rollout), start=1):
        parts.append(f"{_numbered('touchdown', number)} {planned:.3f} s")
        true, detected = flight.touchdown, flight.detected
        parts.append("none simulated" if true is None else f"simulated {true:.3f} s")
        if detected is None:
            parts.append("not detected")
        elif true is not None:
            parts.append(f"detected {decimal(1e3 * (detected - true), 1, signed=True)} ms")
    forces = [f"{a:.2f} to {b:.2f} s" for a, b in force_phases(rollout)]
    if forces:
        parts.append(f"force control {', '.join(forces)}")
    return ", ".join(parts)


def _planned_and_flown(rollout: Rollout) -> list[tuple[float, Flight]]:
    planned = [rollout.outcome.touchdown_planned_s]
    if len(rollout.schedule.flights) > 1:
        ends = [phase + 1 for phase in rollout.schedule.flights]
        planned = rollout.plan.phase_start[ends].tolist()
    return list(zip(planned, flights(rollout), strict=False))  # it may have fallen before the last


def force_phases(rollout: Rollout) -> list[tuple[float, float]]:
    """(start, end) s of each stretch of time in which forces were tracked."""
    times = np.append(rollout.time, rollout.time[-1])
    tracked = stretches(rollout.mode == Mode.FORCE)
    return [(float(times[start]), float(times[end])) for start, end in tracked]
