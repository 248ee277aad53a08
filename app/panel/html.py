"""The panel's pieces of HTML: notes, tables, headings. Everything shown is escaped."""

from collections.abc import Iterable
from html import escape

from app.motion import colours
from app.motion.colours import Rgb

PADDING = "padding:0.35em 0.9em"
SMALL = f"{PADDING};font-size:13px;line-height:1.45"
DIM = "color:var(--mantine-color-dimmed)"
_NAME = (
    "text-align:left;font-weight:normal;padding-right:0.8em;vertical-align:top;white-space:nowrap"
)


def note(text: str, kind: str = "div") -> str:
    """A sentence on what is there, or what to do; `kind`: of its element."""
    return f'<{kind} style="{SMALL};{DIM};font-weight:normal;margin:0">{escape(text)}</{kind}>'


def table(rows: Iterable[tuple[str, str]], title: str = "") -> str:
    """Names and values."""
    body = "".join(
        f'<tr><th scope="row" style="{_NAME};{DIM}">{escape(name)}</th>'
        f'<td style="font-variant-numeric:tabular-nums">{escape(value)}</td></tr>'
        for name, value in rows
    )
    head = f"<b>{escape(title)}</b>" if title else ""
    compact = "border-spacing:0;font-size:12px"
    return f'<div style="{SMALL}">{head}<table style="{compact}">{body}</table></div>'


def heading(text: str) -> str:
    """A line above a group of boxes."""
    return f'<div class="llsrbm-wide" style="{DIM};font-size:12px">{escape(text)}</div>'


def swatch(colour: Rgb) -> str:
    """A small square of a colour, before what it stands for."""
    return (
        '<span style="display:inline-block;width:0.8em;height:0.8em;border-radius:0.2em;'
        f'background:{colours.css(colour)};margin-right:0.5em"></span>'
    )
