"""Charts of one tab: a chosen group of quantities, planned, simulated and pinned together.

Only the charts of the chosen group are in the browser, and only their data are sent. A chart is
changed while its lines stay the same ones, and built anew by the browser when they do not.

The cursor that follows the motion is drawn in the page, without a word from the server: scripts
there call `window.llsrbmPlots.show(seconds)`, which costs a tenth of a millisecond, and hear of
clicks in charts through `window.llsrbmPlots.onPick(seconds => ...)`; see `static/plot_cursor.js`,
which `Plots` sends. `Plots.show_time` draws a cursor from here, for a motion that the server plays.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

import numpy as np
import viser
from numpy.typing import NDArray
from viser import uplot

from app.motion import colours
from app.panel.html import SMALL
from app.panel.validation import option, put
from app.plots.charts import ALL_JOINTS, GROUPS, TORQUES, Layer, joint_kinds
from app.plots.figure import Figure, Rows, Stroke, figure
from app.plots.time_grid import BELOW
from app.viser_link.designer_server import run_javascript

__all__ = ["Layer", "Plots"]

Array = NDArray[np.float64]

_SCRIPT = Path(__file__).parents[1] / "static" / "plot_cursor.js"
_PIXELS = 90  # height of a chart below its title
_FONT = "10px sans-serif"
_DASH = (4.0, 4.0)
_TICKS = uplot.Axis_Ticks(size=3)
_NO_POINTS = uplot.Series_Points(show=False)
_GREY = (128, 128, 128)  # is seen on white and on viser's dark panel
_SHADE, _CURSOR = colours.css(_GREY, 0.15), colours.css(_GREY, 0.9)
_BEFORE_THE_LINES = 3  # series: time, flight, cursor


class Plots:
    """The charts of one tab; for the folder that is open."""

    def __init__(self, client: viser.ClientHandle) -> None:
        """No charts yet."""
        run_javascript(client, _SCRIPT.read_text(encoding="utf-8"))
        self._client = client
        gui = client.gui
        self._group = gui.add_dropdown("Quantity", tuple(GROUPS))
        self._joints = gui.add_dropdown("Joints", (ALL_JOINTS,), visible=False)
        self._legend = gui.add_html("")
        self._container = gui.add_folder(None)
        self._charts: list[_Chart] = []
        self._layers: tuple[Layer, ...] = ()
        self._end = 0.0
        # viser tells of a choice in a thread of its own.
        self._lock = threading.Lock()
        for choice in (self._group, self._joints):
            choice.on_update(self._chosen)

    def draw(self, layers: Sequence[Layer], end: float) -> None:
        """Draw these, the later over the earlier ones and all over those that are pinned.

        Args:
            layers: one of them at least is not pinned.
            end: of the motion that is shown, s.
        """
        with self._lock:
            # Not pinned last; sorting keeps the order of equals.
            self._layers = tuple(sorted(layers, key=lambda layer: not layer.pinned))
            self._end = end
            self._redraw()

    def clear(self) -> None:
        """No charts."""
        with self._lock:
            self._layers = ()
            self._redraw()

    def show_time(self, time: float) -> None:
        """Draw the cursor at a time, s; costs as much as all data, so not for every frame."""
        with self._lock, self._client.atomic():
            for chart in self._charts:
                chart.show_time(time)

    def _chosen(self, event: viser.GuiEvent[viser.GuiDropdownHandle[str]]) -> None:
        if event.client_id is not None:
            with self._lock:
                self._redraw()

    def _redraw(self) -> None:
        group = option("Quantity", self._group.value, tuple(GROUPS), next(iter(GROUPS)), [])
        with self._client.atomic():
            self._joints.visible = group == TORQUES and bool(self._layers)
            if not self._layers:
                self._legend.content = ""
                self._show(None)
                return
            drawn = figure(group, self._layers, self._end, self._choice_of_joints())
            self._legend.content = _legend(drawn)
            self._show(drawn)

    def _choice_of_joints(self) -> str:
        kinds = joint_kinds(self._layers[-1].motion.motion.robot)
        chosen = option("Joints", self._joints.value, kinds, ALL_JOINTS, [])
        if tuple(self._joints.options) != kinds:
            self._joints.options = kinds
            put(self._joints, chosen)
        return chosen

    def _show(self, drawn: Figure | None) -> None:
        rows = () if drawn is None else drawn.charts
        while len(self._charts) < len(rows):
            self._charts.append(_Chart(self._client.gui))
        with self._container:
            for index, chart in enumerate(self._charts):
                if drawn is not None and index < len(rows):
                    chart.draw(drawn, rows[index])
                else:
                    chart.hide()


class _Chart:
    """One chart; added to the page when it is first drawn."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._gui = gui
        self._handle: viser.GuiUplotHandle | None = None
        self._strokes: tuple[tuple[Stroke, ...], tuple[Stroke, ...]] = ((), ())
        self._scales: dict[str, uplot.Scale] = {}
        self._data: tuple[Array, ...] = ()
        self._figure: Figure | None = None

    def draw(self, drawn: Figure, rows: Rows) -> None:
        """Show these lines, without a cursor."""
        cursor = np.full(len(drawn.grid.time), BELOW)
        data = (drawn.grid.time, drawn.flight, cursor, *drawn.marks, *rows.values)
        strokes = (drawn.mark_strokes, rows.strokes)
        scales = _scales(drawn.grid.even, rows.least)
        if self._handle is None:
            self._handle = self._add(rows.title, _series(*strokes), scales, data)
        else:
            # Sent as one, or the browser would see more lines than data.
            if strokes != self._strokes:
                self._handle.series = _series(*strokes)
            if scales != self._scales:
                self._handle.scales = scales
            self._handle.title = rows.title
            self._handle.data = data
            self._handle.visible = True
        self._figure, self._data = drawn, data
        self._strokes, self._scales = strokes, scales

    def hide(self) -> None:
        """Take it off the page."""
        self._figure = None
        if self._handle is not None:
            self._handle.visible = False

    def show_time(self, time: float) -> None:
        """The cursor at a time, s."""
        if self._figure is None or self._handle is None:
            return
        cursor = self._figure.grid.step(time)
        if not np.array_equal(cursor, self._data[_BEFORE_THE_LINES - 1]):
            first, rest = self._data[: _BEFORE_THE_LINES - 1], self._data[_BEFORE_THE_LINES:]
            self._data = (*first, cursor, *rest)
            self._handle.data = self._data

    def _add(
        self,
        title: str,
        series: tuple[uplot.Series, ...],
        scales: dict[str, uplot.Scale],
        data: tuple[Array, ...],
    ) -> viser.GuiUplotHandle:
        return self._gui.add_uplot(
            data,
            series,
            title=title,
            axes=(
                uplot.Axis(size=18, gap=1, font=_FONT, ticks=_TICKS),
                uplot.Axis(size=40, gap=2, font=_FONT, ticks=_TICKS, space=16),
            ),
            scales=scales,
            legend=uplot.Legend(show=False),
            cursor=uplot.Cursor(
                sync=uplot.Cursor_Sync(key="time"), points=uplot.Cursor_Points(show=False)
            ),
            height=_PIXELS,
            padding=(7, 8, 0, 0),
        )


def _scales(time: Array, least: float) -> dict[str, uplot.Scale]:
    # Stated in full: a time axis that is left to viser goes astray when data come together with
    # other lines, or while the browser still measures the chart.
    scales = {
        "x": uplot.Scale(time=False, range=(float(time[0]), float(time[-1]))),
        "marks": uplot.Scale(range=(0.0, 1.0)),
    }
    if least:
        low, high = ({"pad": 0.1, "soft": soft, "mode": 1} for soft in (-least, least))
        scales["y"] = uplot.Scale(range={"min": low, "max": high})
    return scales


def _series(marks: Iterable[Stroke], lines: Iterable[Stroke]) -> tuple[uplot.Series, ...]:
    flight = uplot.Series(
        label="flight", scale="marks", stroke=_SHADE, fill=_SHADE, width=1, points=_NO_POINTS
    )
    cursor = uplot.Series(label="shown", scale="marks", stroke=_CURSOR, width=1, points=_NO_POINTS)
    return (
        uplot.Series(label="s"),
        flight,
        cursor,
        *(_stroked(stroke, "marks", 1.0) for stroke in marks),
        *(_stroked(stroke, "y", 1.0 if stroke.dashed else 1.5) for stroke in lines),
    )


def _stroked(stroke: Stroke, scale: str, width: float) -> uplot.Series:
    series = uplot.Series(
        label=stroke.title,
        scale=scale,
        stroke=colours.css(stroke.colour),
        width=width,
        points=_NO_POINTS,
    )
    if stroke.dashed:
        series["dash"] = _DASH
    return series


def _legend(drawn: Figure) -> str:
    """What is drawn, each thing once."""
    fullest_first = sorted(drawn.charts, key=lambda rows: -len(rows.strokes))
    lines = dict.fromkeys(stroke for rows in fullest_first for stroke in rows.strokes)
    ordered = sorted(lines, key=lambda stroke: stroke.dashed)
    keys = [
        *(
            _key(stroke.title, f"{_line(stroke)};width:1.4em;border-width:2px 0 0")
            for stroke in ordered
        ),
        *(
            _key(stroke.title, f"{_line(stroke)};height:0.9em;border-width:0 0 0 2px")
            for stroke in drawn.mark_strokes
        ),
        _key("flight as planned", f"width:1.1em;height:0.8em;background:{_SHADE}"),
    ]
    return f'<div style="{SMALL};line-height:1.35">{"".join(keys)}</div>'


def _line(stroke: Stroke) -> str:
    return f"border:{'dashed' if stroke.dashed else 'solid'} {colours.css(stroke.colour)}"


def _key(title: str, sample: str) -> str:
    return (
        '<span style="white-space:nowrap;margin-right:1em"><span style="display:inline-block;'
        f'vertical-align:middle;margin-right:0.4em;{sample}"></span>{escape(title)}</span> '
    )
