"""The timeline of a motion: its phases as strips, and what happens when."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from llsrbm import palette
from llsrbm.motion.plan import Phase, Plan
from llsrbm.motion.rollout import Mode, Rollout
from llsrbm.palette import Rgb

PHASES = ("take-off", "flight", "landing")
_STANDING = "standing"


@dataclass(frozen=True)
class Piece:
    """A stretch of a strip: what it is called, from `start` to `end`, s.

    `low` ones lie in the lower half, over others.
    """

    name: str
    start: float
    end: float
    colour: Rgb
    low: bool = False


@dataclass(frozen=True)
class Row:
    """One strip."""

    name: str
    pieces: tuple[Piece, ...]


@dataclass(frozen=True)
class Mark:
    """An instant, s, with a name."""

    name: str
    time: float
    colour: Rgb


@dataclass(frozen=True)
class Timeline:
    """What happens when.

    Attributes:
        rows: strips, the last one is of what is drawn solid.
        marks: in order of time.
        told: the events in one line.
        end: s.
    """

    rows: tuple[Row, ...]
    marks: tuple[Mark, ...]
    told: str
    end: float


def timeline(plan: Plan | None, rollout: Rollout | None = None) -> Timeline:
    """Phases and events of a plan, and of the simulation that followed it.

    Args:
        plan: None where it is not known any more; then there is a rollout.
        rollout: None for a plan alone.
    """
    rows: list[Row] = []
    marks: list[Mark] = []
    told, planned_end = "", math.inf
    end = 0.0 if rollout is None else float(rollout.time[-1])
    if plan is not None:
        planned_end, end = plan.duration, max(plan.duration, end)
        rows.append(_planned(plan, end))
        marks += _planned_marks(plan)
        lift_off, touchdown = plan.phase_start[1:3].tolist()
        told = f"lift-off {lift_off:.2f} s, touch-down {touchdown:.2f} s"
    if rollout is not None:
        if plan is None:
            planned = rollout.outcome.touchdown_planned_s
            marks.append(Mark("touch-down planned", planned, palette.PLANNED))
        rows.append(Row("simulation", _simulated(rollout, planned_end)))
        marks += _simulated_marks(rollout)
        told = _events(rollout)
    return Timeline(tuple(rows), tuple(sorted(marks, key=lambda mark: mark.time)), told, end)


def phase_at(events: Timeline, time: float) -> str:
    """The phase of what is drawn solid."""
    pieces = [piece for piece in events.rows[-1].pieces if not piece.low]
    return next((p.name for p in pieces if p.start <= time < p.end), pieces[-1].name)


def _simulated(rollout: Rollout, planned_end: float) -> tuple[Piece, ...]:
    """The controller's phases, and in them where it tracks forces."""
    time, phase = rollout.time, rollout.phase
    changes = (np.flatnonzero(np.diff(phase)) + 1).tolist()
    edges = [float(time[tick]) for tick in (0, *changes, -1)]
    pieces = [
        Piece(PHASES[int(phase[tick])], a, min(b, planned_end), palette.PHASES[int(phase[tick])])
        for a, b, tick in zip(edges[:-1], edges[1:], (0, *changes), strict=True)
        if a < planned_end
    ]
    if edges[-1] > planned_end:
        pieces.append(Piece(_STANDING, planned_end, edges[-1], palette.STANDING))
    forces = [
        Piece("force control", a, b, palette.FORCE, low=True) for a, b in force_phases(rollout)
    ]
    return (*pieces, *forces)


def _planned(plan: Plan, end: float) -> Row:
    starts = [float(t) for t in plan.phase_start]
    pieces = [
        Piece(name, a, b, colour)
        for name, a, b, colour in zip(PHASES, starts, starts[1:], palette.PHASES, strict=False)
    ]
    if end > plan.duration:
        pieces.append(Piece(_STANDING, plan.duration, end, palette.STANDING))
    return Row("plan", tuple(pieces))


def _planned_marks(plan: Plan) -> list[Mark]:
    flight = np.flatnonzero(plan.phase == Phase.FLIGHT)
    apex = flight[np.argmax(plan.com[flight, 2])]
    return [
        Mark("take-off", float(plan.phase_start[1]), palette.PLANNED),
        Mark("apex", float(plan.time[apex]), palette.PLANNED),
        Mark("touch-down planned", float(plan.phase_start[2]), palette.PLANNED),
    ]


def _simulated_marks(rollout: Rollout) -> list[Mark]:
    outcome = rollout.outcome
    marks = [
        Mark(name, time, palette.SIMULATED)
        for name, time in (
            ("first contact", outcome.touchdown_true_s),
            ("detected", outcome.touchdown_detected_s),
        )
        if time is not None
    ]
    if not rollout.landed:
        marks.append(Mark("fell", float(rollout.time[-1]), palette.INFEASIBLE))
    return marks


def _events(rollout: Rollout) -> str:
    outcome = rollout.outcome
    true, detected = outcome.touchdown_true_s, outcome.touchdown_detected_s
    parts = [f"touch-down {outcome.touchdown_planned_s:.3f} s planned"]
    parts.append("none simulated" if true is None else f"{true:.3f} s simulated")
    if detected is None:
        parts.append("not detected")
    elif true is not None:
        parts.append(f"detected {1e3 * (detected - true):+.1f} ms")
    forces = [f"{a:.2f}-{b:.2f} s" for a, b in force_phases(rollout)]
    if forces:
        parts.append(f"force control {', '.join(forces)}")
    return ", ".join(parts)


def force_phases(rollout: Rollout) -> list[tuple[float, float]]:
    """(start, end) s of each stretch of time in which forces were tracked."""
    on = np.concatenate([[False], rollout.mode == Mode.FORCE, [False]])
    edges = np.flatnonzero(np.diff(on.astype(int)))
    times = np.append(rollout.time, rollout.time[-1])
    return [(float(times[a]), float(times[b])) for a, b in edges.reshape(-1, 2)]
