"""The panel's pieces of HTML: status, timeline, figures, legend. Everything shown is escaped."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

import numpy as np

from app.overlays import (
    ARROW_PER_WEIGHT,
    COM_COLOUR,
    FORCE_COLOUR,
    PLANNED_COLOUR,
    RIGID_COLOUR,
    TARGET_COLOUR,
)
from app.replay import Figures
from llsrbm.trajectory.plan import Plan, Violation

_PADDING = "padding:0.35em 0.9em"
_SMALL = f"{_PADDING};font-size:0.8em;line-height:1.5"

PHASES = ("take-off", "flight", "landing")
_PHASE_COLOURS = ("#e3a93b", "#4c8fdc", "#57a773")
_STATUS_COLOURS = {
    "Planning": "#8a94a0",
    "Planned": "#2f9e62",
    "Failed": "#d6336c",
    "Cancelled": "#d08a1d",
}


def status(word: str, rest: str) -> str:
    """One line that begins with `word`, one of the contract's."""
    colour = _STATUS_COLOURS[word]
    return (
        f'<div role="status" style="{_PADDING};font-size:0.85em;line-height:1.4;'
        f'border-left:4px solid {colour};margin:0.3em 0"><b>{escape(word)}</b> {escape(rest)}</div>'
    )


def planned_line(plan: Plan) -> str:
    """What follows "Planned"."""
    report = plan.report
    return (
        f"in {1e3 * report.solve_time_s:.0f} ms, {report.iterations} iterations, "
        f"largest violation {worst(plan.violations)}"
    )


def worst(violations: dict[str, Violation]) -> str:
    """The largest violation in words."""
    if not violations:
        return "none"
    name, violation = max(violations.items(), key=lambda item: item[1].amount)
    if violation.amount == 0:
        return "0"
    return f"{violation.amount:.1e} {violation.unit} ({name})"


def timeline(plan: Plan, time: float) -> str:
    """The phases as a strip with a cursor, and in which of them the motion is."""
    starts, end = plan.phase_start, plan.duration
    strip = "".join(
        f'<div style="width:{100 * (b - a) / end:.2f}%;background:{colour}"></div>'
        for a, b, colour in zip(starts[:-1], starts[1:], _PHASE_COLOURS, strict=True)
    )
    phase = int(np.clip(np.searchsorted(starts, time, side="right") - 1, 0, 2))
    return (
        f'<div style="{_SMALL}"><div style="position:relative;height:0.8em;display:flex;'
        f'border-radius:0.25em;overflow:hidden">{strip}<div style="position:absolute;'
        f"left:{100 * time / end:.1f}%;top:0;bottom:0;width:3px;margin-left:-1.5px;"
        f'background:#222"></div></div>'
        f'<b style="color:{_PHASE_COLOURS[phase]}">{PHASES[phase]}</b> '
        f"{time:.2f} s of {end:.2f} s · lift-off {starts[1]:.2f} s, touch-down {starts[2]:.2f} s"
        "</div>"
    )


def figures(plan: Plan, values: Figures) -> str:
    """The plan's numbers."""
    phases = " + ".join(f"{seconds:.2f}" for seconds in values.phase_durations)
    report = plan.report
    return table(
        [
            ("Solve time", f"{1e3 * report.solve_time_s:.0f} ms ({report.solver})"),
            ("Iterations", f"{report.iterations}" + _attempts(report.attempts)),
            ("Duration", f"{values.duration:.2f} s = {phases}"),
            ("Peak yaw rate", f"{values.peak_yaw_rate:.2f} rad/s"),
            (
                "Smallest Izz in flight",
                f"{values.smallest_Izz:.2f} kg m² ({values.standing_Izz:.2f} standing)",
            ),
            ("Feet drawn in to", f"{values.feet_radius:.3f} m from the CoM's axis"),
        ]
    )


def _attempts(count: int) -> str:
    return f" ({count} guesses)" if count > 1 else ""


def residuals(violations: dict[str, Violation]) -> str:
    """Every constraint's largest violation, recomputed without the solver."""
    rows = (
        (
            name,
            f"{v.amount:.1e} {v.unit}" + (f", {v.phase} {v.time:.2f} s" if v.amount else ""),
        )
        for name, v in sorted(violations.items(), key=lambda item: -item[1].amount)
    )
    return table(rows)


def table(rows: Iterable[tuple[str, str]]) -> str:
    """Names and values."""
    body = "".join(
        f'<tr><td style="opacity:0.7;padding-right:1em">{escape(name)}</td>'
        f'<td style="font-variant-numeric:tabular-nums">{escape(value)}</td></tr>'
        for name, value in rows
    )
    return f'<div style="{_SMALL}"><table style="border-spacing:0">{body}</table></div>'


def legend() -> str:
    """What the colours mean."""
    rows = (
        (PLANNED_COLOUR, "planned inertia: uniform solid ellipsoid of the robot's mass"),
        (RIGID_COLOUR, "the same for SRBM's constant inertia"),
        (FORCE_COLOUR, f"contact forces; the robot's weight is {ARROW_PER_WEIGHT:g} m long"),
        (COM_COLOUR, "centre of mass; grey: feet in flight"),
        (TARGET_COLOUR, "landing"),
    )
    body = "".join(
        f'<div><span style="display:inline-block;width:0.8em;height:0.8em;border-radius:0.2em;'
        f'background:rgb{colour};margin-right:0.5em"></span>{escape(text)}</div>'
        for colour, text in rows
    )
    return f'<div style="{_SMALL}">{body}</div>'


HELP = (
    f'<div style="{_SMALL}">Move a slider: the jump is planned anew and plays. Drag in the picture '
    "to turn it, right-drag to shift, scroll to zoom. Twist is positive to the left. Everything "
    "here is this tab's own.</div>"
)
