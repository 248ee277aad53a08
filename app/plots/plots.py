"""The charts of one tab, in an area below the picture.

The area is a panel of viser's, which `static/plots.js` keeps below the picture; dragged to a side
of the page it is docked there. Only charts of an open area are in the browser, and only their data
are sent. A chart is changed while its lines stay the same ones, and built anew by the browser when
they do not. The cursor that follows the motion, and the values under the pointer, are drawn in the
page without the server.
"""

import json
from collections.abc import Sequence
from typing import Any

import viser

from app.plots.charts import Layer
from app.plots.choice import PlotChoice
from app.plots.drawing import UplotChart, legend, note
from app.plots.figure import Figure, figure
from app.viser_private import run_javascript

_MOST_DRAWN = 24  # charts; a browser draws each anew for every plan
_PIXELS = ((2, 130), (4, 105))  # up to so many charts -> height of each
_PIXELS_OF_MANY = 95

_TITLE = "Plots"
_MARKER = "llsrbm-plot-area"  # by which plots.js finds the area

# Where the area floats in a page whose script does not run, pixels.
_FLOATING = {"x": 15.0, "y": -110.0, "width": 560.0}


class Plots:
    """Draws a choice of charts of what is shown; keeps only handles and what was drawn last."""

    def __init__(self, client: viser.ClientHandle, watched: Sequence[str]) -> None:
        """`watched`: uuids of the controls that the page's script needs, see static/plots.js."""
        self._client = client
        self._panel = client.gui.add_panel()
        self._area = self._panel.add_tab(_TITLE)
        with self._area:
            self._legend = client.gui.add_html(_marked(note(_EMPTY)))
        self._panel.float(**_FLOATING)
        run_javascript(client, f"window.llsrbm?.plots.watch(...{json.dumps([_TITLE, *watched])})")
        self._charts: list[UplotChart] = []
        self._drawn: tuple[Any, ...] = ()
        self._open = self._reported = True  # as the server had the area last, and the page

    def draw(
        self, layers: Sequence[Layer], end: float, choice: PlotChoice, *, area_open: bool = True
    ) -> tuple[Layer, ...]:
        """Draw layers up to `end`, s, the later over the earlier; or none.

        `area_open`: as the page said last. Gives the layers, those that were drawn before as they
        were then: their signals are known.
        """
        known = self._known(layers)
        self._show_open(choice.open, area_open)
        drawn = (known, end, choice.charts, choice.landing, choice.open)
        if drawn != self._drawn:
            self._drawn = drawn
            with self._client.atomic():
                self._show(known, end, choice)
        return known

    def _known(self, layers: Sequence[Layer]) -> tuple[Layer, ...]:
        """The layers of the last drawing in place of equal ones: their signals are known."""
        before: tuple[Layer, ...] = self._drawn[0] if self._drawn else ()
        return tuple(
            next((known for known in before if known.is_same_as(layer)), layer) for layer in layers
        )

    def _show_open(self, wanted: bool, reported: bool) -> None:
        if reported != self._reported:
            self._open = self._reported = reported
        if wanted != self._open:
            self._open = wanted
            (self._panel.expand if wanted else self._panel.minimize)()

    def _show(self, layers: tuple[Layer, ...], end: float, choice: PlotChoice) -> None:
        drawn: Figure | None = None
        if not layers:
            self._legend.content = _marked(note(_EMPTY))
        elif not choice.charts:
            self._legend.content = _marked(note(_NO_CHARTS))
        elif choice.open:
            drawn = figure(choice, layers, end)
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


_EMPTY = "Charts appear here as soon as there is a motion."
_NO_CHARTS = "No charts. Choose a preset, or a quantity and Add chart."
_NOT_KNOWN = "This motion has none of the chosen quantities."


def _marked(content: str) -> str:
    return f'<div class="{_MARKER}">{content}</div>'
