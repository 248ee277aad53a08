"""The legend above the charts: whose a line is by its colour, which component by its dashes."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from app.motion import colours
from app.motion.colours import Rgb
from app.plots.charts import DASHED
from app.plots.figure import Figure, Stroke
from app.plots.uplot_chart import SHADE

_STYLE = "padding:0.2em 0.9em;font-size:0.8em;line-height:1.5"


def legend(drawn: Figure) -> str:
    """Everything that is drawn, each thing once."""
    strokes = [stroke for rows in drawn.charts for stroke in rows.strokes]
    # A motion has one colour, whatever its components' dashes are.
    motions: dict[tuple[str, Rgb], Stroke] = {}
    for stroke in sorted(strokes, key=lambda stroke: stroke.dash == DASHED):
        motions.setdefault((stroke.title, stroke.colour), stroke)
    keys = [
        *(_line(stroke.title, stroke, colours.css(stroke.colour)) for stroke in motions.values()),
        *(_mark(stroke) for stroke in dict.fromkeys(drawn.mark_strokes)),
        _key("flight as planned", f'<rect width="18" height="12" fill="{SHADE}"/>'),
        *(_line(name, stroke, "currentColor") for name, stroke in _components(strokes).items()),
    ]
    return f'<div style="{_STYLE}">{"".join(keys)}<span>time in s</span></div>'


def note(text: str) -> str:
    """A sentence in place of charts."""
    return f'<div style="{_STYLE}">{escape(text)}</div>'


def _components(strokes: Sequence[Stroke]) -> dict[str, Stroke]:
    """Name -> line, of components that share a chart and have the same dashes in all charts."""
    found: dict[str, Stroke] = {}
    for stroke in strokes:
        if stroke.component and found.setdefault(stroke.component, stroke).dash != stroke.dash:
            return {}
    return found


def _line(title: str, stroke: Stroke, colour: str) -> str:
    dashes = ",".join(f"{length:g}" for length in stroke.dash)
    solid = not stroke.dash or (stroke.component and colour != "currentColor")
    return _key(
        title,
        f'<path d="M0 6H28" stroke="{colour}" stroke-width="2"'
        f'{"" if solid else f""" stroke-dasharray="{dashes}" """}/>',
        28,
    )


def _mark(stroke: Stroke) -> str:
    dashes = ' stroke-dasharray="4,4"' if stroke.dash else ""
    return _key(
        stroke.title,
        f'<path d="M2 0V12" stroke="{colours.css(stroke.colour)}" stroke-width="2"{dashes}/>',
        4,
    )


def _key(title: str, sample: str, width: int = 18) -> str:
    return (
        '<span style="white-space:nowrap;margin-right:1.2em">'
        f'<svg width="{width}" height="12" style="vertical-align:middle;margin-right:0.4em" '
        f'aria-hidden="true">{sample}</svg>{escape(title)}</span> '
    )
