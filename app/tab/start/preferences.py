"""How a visitor likes the page: overlays, plots, dark mode, keys and format, kept by the browser.

The page hands the text back when it is opened again, in this tab and in new ones.
"""

from dataclasses import replace

from pydantic import BaseModel, ValidationError

from app.link import PageReady, SchemeChanged
from app.panel.file_controls import FileChoice
from app.picture.overlays import AT_FIRST, OVERLAYS
from app.plots.choice import DEFAULT, FEWER, MOST_CHARTS, PlotChoice
from app.plots.signals import SIGNALS
from app.tab.acts import on
from app.tab.state import TabState
from llsrbm.formats import FORMATS

_LOW = 900.0  # pixels of a window below which fewer charts are shown at first


class _Kept(BaseModel):
    layers: tuple[str, ...] = tuple(sorted(AT_FIRST))
    night: bool | None = None  # None: as the system has it
    shortcuts: bool = True
    plots: PlotChoice | None = None  # None: as many as the window has room for
    format: str = FileChoice().format


def preferences(state: TabState) -> str:
    """The preferences of a tab, as text to be kept."""
    view, plots = state.view, replace(state.plots, open=True)
    return _Kept(
        layers=tuple(sorted(view.layers)),
        night=None if view.night == state.dark else view.night,
        shortcuts=view.shortcuts,
        # Whether the area is open depends on the size of the window.
        plots=None if plots in (DEFAULT, FEWER) else plots,
        format=state.export.format,
    ).model_dump_json()


def with_preferences(
    state: TabState, text: str | None, *, dark: bool, low: bool = False
) -> TabState:
    """A tab with what its browser kept, as far as it is known here.

    `dark`: the system is. `low`: the window is; the picture has more of it with fewer charts.
    """
    try:
        kept = _Kept() if text is None else _Kept.model_validate_json(text)
    except ValidationError:
        kept = _Kept()
    view = replace(
        state.view,
        layers=frozenset(kept.layers) & OVERLAYS.keys(),
        night=dark if kept.night is None else kept.night,
        shortcuts=kept.shortcuts,
    )
    plots = FEWER if low else DEFAULT
    if kept.plots is not None and _is_known(kept.plots):
        plots = kept.plots
    export = state.export
    if kept.format in FORMATS and kept.format != export.format:
        export = replace(export, format=kept.format).with_own()
    plots = replace(plots, open=state.plots.open)
    return replace(state, dark=dark, view=view, plots=plots, export=export)


def _is_known(plots: PlotChoice) -> bool:
    signals = [chart.signal for chart in (*plots.charts, plots.offered)]
    alone = len(set(plots.charts)) == len(plots.charts) <= MOST_CHARTS
    return alone and all(signal in SIGNALS for signal in signals)


@on(PageReady)
def meet_page(state: TabState, page: PageReady) -> TabState:
    """The page's scripts run; it greets again when its address gets another design."""
    if not state.page:
        low = page.height is not None and page.height < _LOW
        state = with_preferences(state, page.preferences, dark=page.dark, low=low)
    return replace(state, page=True, fine=not page.software)


@on(SchemeChanged)
def follow_system(state: TabState, event: SchemeChanged) -> TabState:
    """The system turns dark or light, and the page with it, unless the visitor chose otherwise."""
    follows = state.view.night == state.dark
    view = replace(state.view, night=event.dark) if follows else state.view
    return replace(state, dark=event.dark, view=view)
