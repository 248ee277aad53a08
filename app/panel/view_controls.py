"""The controls of overlays and light."""

from __future__ import annotations

from typing import Any

import viser

from app.guard.validation import put
from app.panel import html
from app.picture.overlays import OVERLAYS

BRAND = (38, 92, 150)


class ViewControls:
    """A box to tick for each overlay, and the legend, in the container that is open."""

    def __init__(self, gui: viser.GuiApi, shown: frozenset[str]) -> None:
        """Tick what is drawn, by day.

        Args:
            gui: of the tab.
            shown: names of the overlays that are drawn.
        """
        gui.add_html('<div class="llsrbm-boxes"></div>')
        self._boxes = {
            name: gui.add_checkbox(overlay.title, initial_value=name in shown, hint=overlay.hint)
            for name, overlay in OVERLAYS.items()
        }
        self._night = gui.add_checkbox("Night", initial_value=False, hint="A dark page")
        self._legend = gui.add_html(html.legend(shown, simulated=False))

    @property
    def handles(self) -> list[Any]:
        """The controls whose updates change the picture."""
        return [*self._boxes.values(), self._night]

    def read(self) -> tuple[frozenset[str], bool]:
        """Names of the overlays that are ticked, and whether it is night."""
        ticked = frozenset(name for name, box in self._boxes.items() if box.value is True)
        return ticked, self._night.value is True

    def show(self, shown: frozenset[str], *, night: bool) -> None:
        """Tick what is drawn."""
        for name, box in self._boxes.items():
            put(box, name in shown)
        put(self._night, night)

    def show_legend(
        self, shown: frozenset[str], *, simulated: bool, pushed: bool, replans: bool
    ) -> None:
        """Meanings of the colours that are drawn."""
        self._legend.content = html.legend(
            shown, simulated=simulated, pushed=pushed, replans=replans
        )


def configure_theme(gui: viser.GuiApi, *, dark: bool) -> None:
    """The look of all tabs, or of one."""
    gui.configure_theme(
        control_width="medium",
        show_logo=False,
        show_share_button=False,
        brand_color=BRAND,
        dark_mode=dark,
    )
