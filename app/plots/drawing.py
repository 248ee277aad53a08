"""One chart in the page, drawn by viser's uPlot, and the legend above all charts."""

from collections.abc import Sequence
from html import escape

import viser
from viser import uplot

from app.motion import colours
from app.plots.charts import Chart, Line, Look, Role
from app.plots.figure import Figure
from llsrbm.arrays import Array

_FONT = "11px system-ui, sans-serif"
_TICKS = uplot.Axis_Ticks(size=3)
_NO_POINTS = uplot.Series_Points(show=False)
_GREY = (128, 128, 128)  # is seen on white and on viser's dark panel
_SHADE = colours.css(_GREY, 0.15)  # of the flight
_LINE_SCALE, _MARK_SCALE = "y", "marks"
_WIDTH = 1.5  # pixels
# What a line is, for static/plots.js: the values of what is aside are in the box alone.
_KINDS = {Role.MOTION: "curve", Role.SECOND: "curve aside", Role.LIMIT: "curve aside"}
_STYLE = "padding:0.2em 0.9em;font-size:12px;line-height:1.5"

Scales = dict[str, uplot.Scale]


class UplotChart:
    """Added to the page when it is first drawn; changed, not made anew, while its lines stay."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._gui = gui
        self._handle: viser.GuiUplotHandle | None = None
        self._looks: list[Look] = []
        self._scales: Scales = {}

    def draw(self, drawn: Figure, chart: Chart, pixels: int) -> None:
        """Show a chart of a figure; `pixels` is its height below the title."""
        lines = (*drawn.marks, *chart.lines)
        data = (drawn.grid.time, drawn.flight, *(line.values for line in lines))
        looks = [line.look for line in lines]
        scales = _scales(drawn.grid.even, chart.least)
        if self._handle is None:
            self._handle = self._add(chart.heading, _series(drawn, chart), scales, data, pixels)
        else:
            # A browser may draw between any two of these: it must never see more lines than data.
            grows = len(looks) > len(self._looks)
            if grows:
                self._handle.data = data
            if looks != self._looks:
                self._handle.series = _series(drawn, chart)
            if scales != self._scales:
                self._handle.scales = scales
            self._handle.title = chart.heading
            self._handle.height = pixels
            if not grows:
                self._handle.data = data
            self._handle.visible = True
        self._looks, self._scales = looks, scales

    def hide(self) -> None:
        """Take it off the page."""
        if self._handle is not None:
            self._handle.visible = False

    def _add(
        self,
        title: str,
        series: tuple[uplot.Series, ...],
        scales: Scales,
        data: tuple[Array, ...],
        pixels: int,
    ) -> viser.GuiUplotHandle:
        return self._gui.add_uplot(
            data,
            series,
            title=title,
            axes=(
                uplot.Axis(size=20, gap=2, font=_FONT, ticks=_TICKS, space=44),
                uplot.Axis(size=48, gap=3, font=_FONT, ticks=_TICKS, space=20),
            ),
            scales=scales,
            legend=uplot.Legend(show=False),
            cursor=uplot.Cursor(
                sync=uplot.Cursor_Sync(key="time"), points=uplot.Cursor_Points(show=False)
            ),
            height=pixels,
            padding=(7, 12, 0, 0),
        )


def _scales(time: Array, least: float) -> Scales:
    # Stated in full: a time axis that is left to viser goes astray when data come together with
    # other lines, or while the browser still measures the chart.
    scales = {
        "x": uplot.Scale(time=False, range=(float(time[0]), float(time[-1]))),
        _MARK_SCALE: uplot.Scale(range=(0.0, 1.0)),
    }
    if least:
        low, high = ({"pad": 0.1, "soft": soft, "mode": 1} for soft in (-least, least))
        scales[_LINE_SCALE] = uplot.Scale(range={"min": low, "max": high})
    return scales


def _series(drawn: Figure, chart: Chart) -> tuple[uplot.Series, ...]:
    flight = uplot.Series(
        label="flight", scale=_MARK_SCALE, stroke=_SHADE, fill=_SHADE, width=1, points=_NO_POINTS
    )
    return (
        uplot.Series(label="s"),
        flight,
        *(_stroked(line, _MARK_SCALE, 1.0, "mark") for line in drawn.marks),
        *(_stroked(line, _LINE_SCALE, _WIDTH, _KINDS[line.role]) for line in chart.lines),
    )


def _stroked(line: Line, scale: str, width: float, kind: str) -> uplot.Series:
    series = uplot.Series(
        label=line.name,
        scale=scale,
        stroke=colours.css(line.colour),
        width=width,
        points=_NO_POINTS,
    )
    series["class"] = kind
    if line.dash:
        series["dash"] = line.dash
    return series


# ---- the legend


def legend(drawn: Figure) -> str:
    """Everything that is drawn, each thing once: motions by their dashes, components by colour.

    Where a chart has one component, a line has its motion's colour too.
    """
    lines = [line for chart in drawn.charts for line in chart.lines]
    motions: dict[str, Line] = {}
    for line in sorted(
        lines, key=lambda line: (line.role is not Role.MOTION, bool(line.component))
    ):
        motions.setdefault(line.title, line)
    keys = [
        *(_key_of_motion(each) for each in motions.values()),
        *(_key_of_mark(mark) for mark in {mark.look: mark for mark in drawn.marks}.values()),
        _key("flight as planned", f'<rect width="18" height="12" fill="{_SHADE}"/>'),
        *(_stroke(name, colours.css(rgb)) for name, rgb in _components(lines).items()),
    ]
    return f'<div style="{_STYLE}">{"".join(keys)}<span>time in s</span></div>'


def note(text: str) -> str:
    """A sentence in place of charts."""
    return f'<div style="{_STYLE}">{escape(text)}</div>'


def _components(lines: Sequence[Line]) -> dict[str, colours.Rgb]:
    """Name -> colour, of components that share a chart and have the same colour in all charts."""
    found: dict[str, colours.Rgb] = {}
    for line in lines:
        if line.component and found.setdefault(line.component, line.colour) != line.colour:
            return {}
    return found


def _key_of_motion(line: Line) -> str:
    colour = "currentColor" if line.component else colours.css(line.colour)
    return _stroke(line.title, colour, line.dash)


def _stroke(title: str, colour: str, dash: tuple[float, ...] = ()) -> str:
    dashes = ",".join(f"{length:g}" for length in dash)
    style = f' stroke-dasharray="{dashes}"' if dash else ""
    return _key(title, f'<path d="M0 6H28" stroke="{colour}" stroke-width="2"{style}/>', 28)


def _key_of_mark(mark: Line) -> str:
    dashes = ' stroke-dasharray="4,4"' if mark.dash else ""
    return _key(
        mark.title,
        f'<path d="M2 0V12" stroke="{colours.css(mark.colour)}" stroke-width="2"{dashes}/>',
        4,
    )


def _key(title: str, sample: str, width: int = 18) -> str:
    return (
        '<span style="white-space:nowrap;margin-right:1.2em">'
        f'<svg width="{width}" height="12" style="vertical-align:middle;margin-right:0.4em" '
        f'aria-hidden="true">{sample}</svg>{escape(title)}</span> '
    )
