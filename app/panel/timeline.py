"""The timeline as HTML with a cursor, for panels of pages that do not draw their own."""

from __future__ import annotations

from html import escape

from app.motion import colours
from app.motion.colours import Rgb
from app.panel.html import SMALL
from llsrbm.motion.timeline import Piece, Timeline, phase_at


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
