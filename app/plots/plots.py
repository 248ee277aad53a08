"""The charts of one tab: controls in the panel, charts in an area below the picture.

The area is a panel of viser's, which `static/plot_area.js` keeps below the picture; dragged to a
side of the page it is docked there. The page says when it is opened or minimised. Only charts of
an open area are in the browser, and only their data are sent. A chart is changed while its lines
stay the same ones, and built anew by the browser when they do not.

The cursor that follows the motion, and the values under the pointer, are drawn in the page without
the server: see `static/plot_cursor.js`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import viser

from app.link import ChartDropped
from app.plots.charts import Layer, charts, csv_of
from app.plots.choice import PlotChoice
from app.plots.controls import PlotControls
from app.plots.drawing import UplotChart, legend, note
from app.plots.figure import Figure, figure
from app.viser_private import run_javascript, uuid_of

__all__ = ["Layer", "PlotChoice", "Plots"]

_STATIC = Path(__file__).parents[1] / "static"
_SCRIPTS = ("plot_cursor.js", "plot_area.js")

_MOST_DRAWN = 24  # charts; a browser draws each anew for every plan
_PIXELS = ((2, 130), (4, 105))  # up to so many charts -> height of each
_PIXELS_OF_MANY = 95

_TITLE = "Plots"
_MARKER = "llsrbm-plot-area"  # by which plot_area.js finds the area

# Where the area floats in a page whose script does not run, pixels.
_FLOATING = {"x": 15.0, "y": -110.0, "width": 560.0}


class Plots:
    """Draws a choice of charts of what is shown; keeps only handles and what was drawn last."""

    def __init__(self, client: viser.ClientHandle, chosen: Callable[[PlotChoice], None]) -> None:
        """`chosen` is called on viser's event loop with the user's choice; must return at once."""
        self._client = client
        self._controls = PlotControls(client.gui, chosen)
        self._controls.download.on_click(self._download)
        self._panel = client.gui.add_panel()
        self._area = self._panel.add_tab(_TITLE)
        with self._area:
            self._legend = client.gui.add_html(_marked(note(_EMPTY)))
        self._panel.float(**_FLOATING)
        for script in _SCRIPTS:
            run_javascript(client, (_STATIC / script).read_text(encoding="utf-8"))
        controls = (self._controls.open, self._controls.seen, self._controls.add)
        watched = (_TITLE, *map(uuid_of, controls))
        run_javascript(client, f"window.llsrbmPlots?.watch(...{json.dumps(watched)})")
        self._charts: list[UplotChart] = []
        self._layers: tuple[Layer, ...] = ()
        self._end = 0.0
        self._choice: PlotChoice | None = None

    def draw(self, layers: Sequence[Layer], end: float, choice: PlotChoice) -> None:
        """Draw layers up to `end`, s: the later over the earlier, all over the pinned; or none."""
        # Not pinned last; sorting keeps the order of equals.
        ordered = self._known(sorted(layers, key=lambda layer: not layer.pinned))
        same_motions = ordered == self._layers and end == self._end
        if same_motions and choice == self._choice:
            return
        before, self._choice = self._choice, choice
        self._layers, self._end = ordered, end
        with self._client.atomic():
            self._controls.show(choice, ordered)
            self._show_open(choice.open)
            if not (same_motions and before is not None and _as_drawn(before) == _as_drawn(choice)):
                self._show(choice)

    def dropped(self, event: ChartDropped) -> PlotChoice | None:
        """The choice with a chart's signals in the chart that they were dropped onto, by titles."""
        choice = self._choice
        if choice is None:
            return None
        shown = {chart.heading: chart.source for chart in charts(choice, self._layers)}
        source = choice.offered if event.chart is None else shown.get(event.chart)
        onto = shown.get(event.onto)
        if source is None or onto is None:
            return None
        if onto not in choice.charts or (event.chart and source not in choice.charts):
            choice = replace(choice, charts=tuple(shown.values()))  # a chart each, one by one
        return choice.with_joined(source, onto)

    def _known(self, layers: Sequence[Layer]) -> tuple[Layer, ...]:
        """The layers of the last drawing in place of equal ones: their signals are known."""
        return tuple(
            next((known for known in self._layers if known.is_same_as(layer)), layer)
            for layer in layers
        )

    def _show_open(self, open_: bool) -> None:
        if open_ != self._controls.area_open:
            self._controls.area_open = open_
            (self._panel.expand if open_ else self._panel.minimize)()

    def _show(self, choice: PlotChoice) -> None:
        drawn: Figure | None = None
        if not self._layers:
            self._legend.content = _marked(note(_EMPTY))
        elif not choice.charts:
            self._legend.content = _marked(note(_NO_CHARTS))
        elif choice.open:
            drawn = figure(choice, self._layers, self._end)
            self._legend.content = _marked(legend(drawn) if drawn.charts else note(_NOT_KNOWN))
        rows = () if drawn is None else drawn.charts[:_MOST_DRAWN]
        pixels = next((p for count, p in _PIXELS if len(rows) <= count), _PIXELS_OF_MANY)
        while len(self._charts) < len(rows):
            self._charts.append(UplotChart(self._client.gui))
        with self._area:
            for index, chart in enumerate(self._charts):
                if drawn is not None and index < len(rows):
                    chart.draw(drawn, rows[index], pixels)
                else:
                    chart.hide()

    def _download(self, _event: viser.GuiEvent[Any]) -> None:
        # In one of viser's threads: what was drawn is read once, and is not changed.
        layers, choice = self._layers, self._choice
        if layers and choice is not None:
            self._client.send_file_download(
                "plots.csv", csv_of(layers, choice), save_immediately=True
            )


_EMPTY = "Charts appear here as soon as there is a motion."
_NO_CHARTS = "No charts. Choose a preset, or a quantity and Add chart."
_NOT_KNOWN = "This motion has none of the chosen quantities."


def _marked(content: str) -> str:
    return f'<div class="{_MARKER}">{content}</div>'


def _as_drawn(choice: PlotChoice) -> tuple[Any, ...]:
    return choice.charts, choice.landing, choice.open
