"""The panel's pieces of HTML: status, tables, legend. Everything shown is escaped."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

from app.motion import colours
from app.motion.colours import Rgb
from app.panel.status import Status, Word
from app.scene.overlays.forces import ARROW_PER_WEIGHT

PADDING = "padding:0.35em 0.9em"
SMALL = f"{PADDING};font-size:0.8em;line-height:1.5"

_STATUS_COLOURS = {
    Word.PLANNING: "#8a94a0",
    Word.PLANNED: "#2f9e62",
    Word.SIMULATING: "#8a94a0",
    Word.LANDED: "#2f9e62",
    Word.FELL: "#d6336c",
    Word.FAILED: "#d6336c",
    Word.CANCELLED: "#d08a1d",
}


def status(status: Status) -> str:
    """One line that begins with one of the contract's words."""
    colour = _STATUS_COLOURS[status.word]
    return (
        f'<div role="status" style="{PADDING};font-size:0.85em;line-height:1.4;'
        f'border-left:4px solid {colour};margin:0.3em 0"><b>{escape(status.word.value)}</b> '
        f"{escape(status.rest)}</div>"
    )


def note(text: str) -> str:
    """A sentence on what is there, or what to do."""
    return f'<div style="{SMALL};opacity:0.8">{escape(text)}</div>'


def table(rows: Iterable[tuple[str, str]], title: str = "") -> str:
    """Names and values."""
    body = "".join(
        f'<tr><td style="opacity:0.7;padding-right:1em;vertical-align:top">{escape(name)}</td>'
        f'<td style="font-variant-numeric:tabular-nums">{escape(value)}</td></tr>'
        for name, value in rows
    )
    head = f"<b>{escape(title)}</b>" if title else ""
    return f'<div style="{SMALL}">{head}<table style="border-spacing:0">{body}</table></div>'


def legend(*, simulated: bool) -> str:
    """What the colours in the picture mean, with or without a simulation."""
    rows: tuple[tuple[Rgb, str], ...] = (
        (colours.PLANNED, "planned inertia: uniform solid ellipsoid of the robot's mass"),
    )
    if simulated:
        rows += (
            (colours.SIMULATED, "the same for the simulated whole body's inertia"),
            (colours.PLANNED, "ghost: the plan; solid: the simulated robot"),
            (colours.FORCE, f"forces measured; the robot's weight is {ARROW_PER_WEIGHT:g} m long"),
        )
    else:
        rows += (
            (colours.RIGID, "the same for SRBM's constant inertia"),
            (colours.FORCE, f"contact forces; the robot's weight is {ARROW_PER_WEIGHT:g} m long"),
        )
    rows += (
        (colours.COM, "centre of mass; grey: feet in flight"),
        (colours.TARGET, "landing"),
    )
    return _keys(rows)


def _keys(rows: Iterable[tuple[Rgb, str]]) -> str:
    body = "".join(f"<div>{swatch(colour)}{escape(text)}</div>" for colour, text in rows)
    return f'<div style="{SMALL}">{body}</div>'


def swatch(colour: Rgb) -> str:
    """A small square of a colour, before what it stands for."""
    return (
        '<span style="display:inline-block;width:0.8em;height:0.8em;border-radius:0.2em;'
        f'background:{colours.css(colour)};margin-right:0.5em"></span>'
    )
