"""One chart in the page, drawn by viser's uPlot."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import viser
from numpy.typing import NDArray
from viser import uplot

from app.motion import colours
from app.plots.figure import Figure, Rows, Stroke

Array = NDArray[np.float64]

_FONT = "11px system-ui, sans-serif"
_TICKS = uplot.Axis_Ticks(size=3)
_NO_POINTS = uplot.Series_Points(show=False)
_GREY = (128, 128, 128)  # is seen on white and on viser's dark panel
SHADE = colours.css(_GREY, 0.15)
"""Of the flight."""

_LINE_SCALE, _MARK_SCALE = "y", "marks"
_WIDTH = 1.5  # pixels

Scales = dict[str, uplot.Scale]


class UplotChart:
    """Added to the page when it is first drawn; changed, not made anew, while its lines stay."""

    def __init__(self, gui: viser.GuiApi) -> None:
        """Nothing in the page yet; the chart will be in the container that is open at `draw`."""
        self._gui = gui
        self._handle: viser.GuiUplotHandle | None = None
        self._strokes: tuple[tuple[Stroke, ...], tuple[Stroke, ...]] = ((), ())
        self._scales: Scales = {}

    def draw(self, drawn: Figure, rows: Rows, pixels: int) -> None:
        """Show these lines.

        Args:
            drawn: what all charts share.
            rows: the chart.
            pixels: height below the title.
        """
        data = (drawn.grid.time, drawn.flight, *drawn.marks, *rows.values)
        strokes = (drawn.mark_strokes, rows.strokes)
        scales = _scales(drawn.grid.even, rows.least)
        if self._handle is None:
            self._handle = self._add(rows.title, _series(*strokes), scales, data, pixels)
        else:
            # Sent as one, or the browser would see more lines than data.
            if strokes != self._strokes:
                self._handle.series = _series(*strokes)
            if scales != self._scales:
                self._handle.scales = scales
            self._handle.title = rows.title
            self._handle.height = pixels
            self._handle.data = data
            self._handle.visible = True
        self._strokes, self._scales = strokes, scales

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


def _series(marks: Iterable[Stroke], lines: Iterable[Stroke]) -> tuple[uplot.Series, ...]:
    flight = uplot.Series(
        label="flight", scale=_MARK_SCALE, stroke=SHADE, fill=SHADE, width=1, points=_NO_POINTS
    )
    return (
        uplot.Series(label="s"),
        flight,
        *(_stroked(stroke, _MARK_SCALE, 1.0) for stroke in marks),
        *(_stroked(stroke, _LINE_SCALE, _WIDTH) for stroke in lines),
    )


def _stroked(stroke: Stroke, scale: str, width: float) -> uplot.Series:
    series = uplot.Series(
        label=stroke.name,
        scale=scale,
        stroke=colours.css(stroke.colour),
        width=width,
        points=_NO_POINTS,
    )
    if stroke.dash:
        series["dash"] = stroke.dash
    return series
