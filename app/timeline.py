"""The timeline: phases as strips, what happened when, and both as HTML with a cursor."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

import numpy as np

from app import colours
from app.colours import Rgb
from app.markup import SMALL
from app.simulated_replay import force_phases
from llsrbm.motion.plan import Phase, Plan
from llsrbm.motion.rollout import Rollout

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


def timeline(plan: Plan, rollout: Rollout | None = None) -> Timeline:
    """Phases and events of a plan, and of the simulation that followed it."""
    end = plan.duration if rollout is None else max(plan.duration, float(rollout.time[-1]))
    starts = [float(t) for t in plan.phase_start]
    planned = [
        Piece(name, a, b, colour)
        for name, a, b, colour in zip(PHASES, starts, starts[1:], colours.PHASES, strict=False)
    ]
    if end > plan.duration:
        planned.append(Piece(_STANDING, plan.duration, end, colours.STANDING))
    rows = [Row("plan", tuple(planned))]
    if rollout is not None:
        rows.append(Row("simulation", _simulated(rollout, plan.duration)))
    told = (
        f"lift-off {starts[1]:.2f} s, touch-down {starts[2]:.2f} s"
        if rollout is None
        else _events(rollout)
    )
    return Timeline(tuple(rows), _marks(plan, rollout), told, end)


def html(events: Timeline, time: float) -> str:
    """The strips with a cursor at `time`, s, and the phase it is in."""
    strips = "".join(
        '<div style="position:relative;height:0.8em;border-radius:0.25em;overflow:hidden;'
        f'margin-bottom:2px">{"".join(_piece(piece, events.end) for piece in row.pieces)}</div>'
        for row in events.rows
    )
    marks = "".join(_line(m.name, m.time / events.end, m.colour, 2) for m in events.marks)
    cursor = _line("", time / events.end, colours.CURSOR, 3)
    phase = phase_at(events, time)
    return (
        f'<div style="{SMALL}"><div style="position:relative">{strips}{marks}{cursor}</div>'
        f"<b>{escape(phase)}</b> {time:.2f} s of {events.end:.2f} s · {escape(events.told)}</div>"
    )


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
        Piece(PHASES[int(phase[tick])], a, min(b, planned_end), colours.PHASES[int(phase[tick])])
        for a, b, tick in zip(edges[:-1], edges[1:], (0, *changes), strict=True)
        if a < planned_end
    ]
    if edges[-1] > planned_end:
        pieces.append(Piece(_STANDING, planned_end, edges[-1], colours.STANDING))
    forces = [
        Piece("force control", a, b, colours.FORCE, low=True) for a, b in force_phases(rollout)
    ]
    return (*pieces, *forces)


def _marks(plan: Plan, rollout: Rollout | None) -> tuple[Mark, ...]:
    flight = np.flatnonzero(plan.phase == Phase.FLIGHT)
    apex = flight[np.argmax(plan.com[flight, 2])]
    marks = [
        Mark("take-off", float(plan.phase_start[1]), colours.PLANNED),
        Mark("apex", float(plan.time[apex]), colours.PLANNED),
        Mark("touch-down planned", float(plan.phase_start[2]), colours.PLANNED),
    ]
    if rollout is not None:
        outcome = rollout.outcome
        for name, time in (
            ("first contact", outcome.touchdown_true_s),
            ("detected", outcome.touchdown_detected_s),
        ):
            if time is not None:
                marks.append(Mark(name, time, colours.SIMULATED))
        if not rollout.landed:
            marks.append(Mark("fell", float(rollout.time[-1]), colours.INFEASIBLE))
    return tuple(sorted(marks, key=lambda mark: mark.time))


def _piece(piece: Piece, end: float) -> str:
    return (
        f'<div title="{escape(piece.name)}" style="position:absolute;'
        f"left:{100 * piece.start / end:.2f}%;width:{100 * (piece.end - piece.start) / end:.2f}%;"
        f'top:{35 if piece.low else 0}%;bottom:0;background:{colours.css(piece.colour)}"></div>'
    )


def _line(title: str, share: float, colour: Rgb, width: int) -> str:
    return (
        f'<div title="{escape(title)}" style="position:absolute;left:{100 * share:.2f}%;'
        f"width:{width}px;top:0;bottom:0;"
        f'margin-left:-{width / 2}px;background:{colours.css(colour)}"></div>'
    )


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
