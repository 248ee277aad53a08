"""The timeline: phases as strips with a cursor, and what happened when."""

from __future__ import annotations

from html import escape

import numpy as np

from app import colours
from app.colours import Rgb
from app.markup import SMALL
from app.simulated_replay import force_phases
from llsrbm.trajectory.plan import Plan
from llsrbm.trajectory.rollout import Rollout

PHASES = ("take-off", "flight", "landing")
_STANDING = "standing"


def timeline(plan: Plan, time: float, rollout: Rollout | None = None) -> str:
    """The phases, planned and simulated, and in which of them the motion is at `time`, s."""
    end = plan.duration if rollout is None else max(plan.duration, float(rollout.time[-1]))
    starts = plan.phase_start
    planned = [
        (float(a), float(b), colour)
        for a, b, colour in zip(starts[:-1], starts[1:], colours.PHASES, strict=True)
    ]
    if end > plan.duration:
        planned.append((plan.duration, end, colours.STANDING))
    rows = [_strip(planned, end)]
    if rollout is not None:
        rows.append(_simulated_strip(rollout, plan.duration, end))
    cursor = _mark("", time / end, colours.CURSOR, 3)
    if rollout is None:
        phase = _phase(starts, time)
        events = f"lift-off {starts[1]:.2f} s, touch-down {starts[2]:.2f} s"
    else:
        phase = _controller_phase(plan, rollout, time)
        events = _events(rollout)
    colour = colours.PHASES[PHASES.index(phase)] if phase in PHASES else colours.FOOT
    return (
        f'<div style="{SMALL}"><div style="position:relative">{"".join(rows)}{cursor}</div>'
        f'<b style="color:{colours.css(colour)}">{phase}</b> '
        f"{time:.2f} s of {end:.2f} s · {events}</div>"
    )


def _simulated_strip(rollout: Rollout, planned_end: float, end: float) -> str:
    """The controller's phases, the force phase in them, touchdown and its detection."""
    time, phase = rollout.time, rollout.phase
    changes = (np.flatnonzero(np.diff(phase)) + 1).tolist()
    edges = [float(time[tick]) for tick in (0, *changes, -1)]
    pieces = [
        (a, min(b, planned_end), colours.PHASES[int(phase[tick])])
        for a, b, tick in zip(edges[:-1], edges[1:], (0, *changes), strict=True)
        if a < planned_end
    ]
    if edges[-1] > planned_end:
        pieces.append((planned_end, edges[-1], colours.STANDING))
    marks = "".join(
        f'<div title="force control" style="position:absolute;left:{100 * a / end:.2f}%;'
        f"width:{100 * (b - a) / end:.2f}%;top:35%;bottom:0;"
        f'background:{colours.css(colours.FORCE)}"></div>'
        for a, b in force_phases(rollout)
    )
    # The detection is broad and below: a few ms later, it would hide the touch-down.
    outcome = rollout.outcome
    if outcome.touchdown_detected_s is not None:
        marks += _mark("detected", outcome.touchdown_detected_s / end, colours.DETECTION, 6)
    if outcome.touchdown_true_s is not None:
        marks += _mark("touch-down", outcome.touchdown_true_s / end, colours.CURSOR, 2)
    return _strip(pieces, end, marks)


def _strip(pieces: list[tuple[float, float, Rgb]], end: float, marks: str = "") -> str:
    body = "".join(
        f'<div style="width:{100 * (b - a) / end:.2f}%;background:{colours.css(colour)}"></div>'
        for a, b, colour in pieces
    )
    return (
        '<div style="position:relative;height:0.8em;display:flex;border-radius:0.25em;'
        f'overflow:hidden;margin-bottom:2px">{body}{marks}</div>'
    )


def _mark(title: str, share: float, colour: Rgb, width: int) -> str:
    return (
        f'<div title="{escape(title)}" style="position:absolute;left:{100 * share:.2f}%;'
        f"width:{width}px;top:0;bottom:0;"
        f'margin-left:-{width / 2}px;background:{colours.css(colour)}"></div>'
    )


def _phase(starts: np.ndarray, time: float) -> str:
    return PHASES[int(np.clip(np.searchsorted(starts, time, side="right") - 1, 0, 2))]


def _controller_phase(plan: Plan, rollout: Rollout, time: float) -> str:
    if time > plan.duration:
        return _STANDING
    tick = int(np.searchsorted(rollout.time, time, side="right") - 1)
    return PHASES[int(rollout.phase[np.clip(tick, 0, len(rollout.time) - 1)])]


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
    return escape(", ".join(parts))
