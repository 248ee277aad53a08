"""The controls of overlays and light; the colours of what is drawn stand beside its box."""

from dataclasses import dataclass, replace
from functools import partial

import viser

from app.motion import colours
from app.panel import html
from app.panel.acts import Act, Put
from app.panel.fields import Field, Fields
from app.picture.drawing import Group
from app.picture.overlays import AT_FIRST, OVERLAYS
from app.picture.picture import Picture
from app.viser_private import uuid_of

_MARKER = '<div class="llsrbm-boxes"></div>'  # of a box of checkboxes (static/panel.js)
BRAND = (62, 78, 99)  # no motion has it


@dataclass(frozen=True)
class View:
    """The overlays that are drawn, and in which light."""

    layers: frozenset[str] = AT_FIRST  # names of overlays
    night: bool = False  # a dark page
    shortcuts: bool = True  # keys of the page, beside those of its controls


def _shows(name: str, view: View) -> bool:
    return name in view.layers


def _with_layer(name: str, view: View, on: bool) -> View:
    return replace(view, layers=view.layers | {name} if on else view.layers - {name})


BOXES: dict[str, Field[View]] = {
    name: Field(overlay.title, overlay.hint, partial(_shows, name), partial(_with_layer, name))
    for name, overlay in OVERLAYS.items()
}
"""Of the overlays, by name; an overlay has one by itself."""

SWITCHES: tuple[Field[View], ...] = (
    Field(
        "Keyboard shortcuts",
        "Keys for the motion (space, arrows, Home, End) and the picture (0 to 3, F, P)",
        lambda view: view.shortcuts,
        lambda view, on: replace(view, shortcuts=on),
    ),
    Field(
        "Dark mode",
        "Show the page in dark colours",
        lambda view: view.night,
        lambda view, on: replace(view, night=on),
    ),
)
"""Of the page; a switch more is a row here and its field in `View`."""


class ViewControls:
    """A box to tick for each overlay and switch, in the container that is open."""

    def __init__(self, gui: viser.GuiApi, view: View, put: Put) -> None:
        gui.add_html(_MARKER)
        self.fields = Fields(gui, view, None, put, Act.VIEW)  # the boxes
        self.fields.add(*(BOXES[name] for name, each in OVERLAYS.items() if each.common))
        with gui.add_folder("More overlays", expand_by_default=False):
            gui.add_html(_MARKER)
            for group in Group:
                gui.add_html(html.heading(group.value))
                rest = [
                    n for n, each in OVERLAYS.items() if each.group is group and not each.common
                ]
                self.fields.add(*(BOXES[name] for name in rest))
        gui.add_html(html.heading("Page"))
        self.fields.add(*SWITCHES)

    def swatches(self, picture: Picture) -> dict[str, list[str]]:
        """The colours of each overlay's box, by its uuid, as CSS; none: it shows nothing now."""
        return {
            uuid_of(self.fields.handle(BOXES[name])): [
                colours.css(colour)
                for colour in overlay.swatch(picture)
                if picture.planned is not None or not overlay.needs_motion
            ]
            for name, overlay in OVERLAYS.items()
        }


def configure_theme(gui: viser.GuiApi, *, dark: bool) -> None:
    """The look of all tabs, or of one."""
    gui.configure_theme(
        control_width="medium",
        show_logo=False,
        show_share_button=False,
        brand_color=BRAND,
        dark_mode=dark,
    )
