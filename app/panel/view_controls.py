"""The controls of overlays and light, and the legend of what is drawn."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import viser

from app.panel import html
from app.panel.acts import Act, Put
from app.panel.fields import Field, Fields
from app.picture.overlays import AT_FIRST, OVERLAYS
from app.picture.picture import Picture

BRAND = (38, 92, 150)


@dataclass(frozen=True)
class View:
    """The overlays that are drawn, and in which light."""

    layers: frozenset[str] = AT_FIRST  # names of overlays
    night: bool = False  # a dark page


def _shows(name: str, view: View) -> bool:
    return name in view.layers


def _with_layer(name: str, view: View, on: bool) -> View:
    return replace(view, layers=view.layers | {name} if on else view.layers - {name})


SWITCHES: tuple[Field[View], ...] = (
    *(
        Field(overlay.title, overlay.hint, partial(_shows, name), partial(_with_layer, name))
        for name, overlay in OVERLAYS.items()
    ),
    Field(
        "Night", "A dark page", lambda view: view.night, lambda view, on: replace(view, night=on)
    ),
)
"""A switch more is a row here and its field in `View`; an overlay has one by itself."""


class ViewControls:
    """A box to tick for each switch, and the legend, in the container that is open."""

    def __init__(self, gui: viser.GuiApi, view: View, put: Put) -> None:
        gui.add_html('<div class="llsrbm-boxes"></div>')
        self.fields = Fields(gui, view, None, put, Act.VIEW)  # the boxes
        self.fields.add(SWITCHES)
        self._legend = gui.add_html("")

    def show_legend(self, picture: Picture) -> None:
        """Meanings of the colours that are drawn."""
        shown = (overlay for name, overlay in OVERLAYS.items() if name in picture.layers)
        self._legend.content = html.legend(key for each in shown for key in each.keys(picture))


def configure_theme(gui: viser.GuiApi, *, dark: bool) -> None:
    """The look of all tabs, or of one."""
    gui.configure_theme(
        control_width="medium",
        show_logo=False,
        show_share_button=False,
        brand_color=BRAND,
        dark_mode=dark,
    )
