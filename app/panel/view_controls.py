"""What is drawn besides the robot, and in which light."""

from __future__ import annotations

from typing import Any

import viser

from app.panel import html
from app.scene.overlays import OVERLAYS

BRAND = (38, 92, 150)


class ViewControls:
    """A box for every overlay, one for the night, and the legend; added to the open folder."""

    def __init__(self, gui: viser.GuiApi) -> None:
        """By day, with the overlays that are drawn at first."""
        self._gui = gui
        self._boxes = {
            name: gui.add_checkbox(overlay.title, overlay.at_first, hint=overlay.hint)
            for name, overlay in OVERLAYS.items()
        }
        self._night = gui.add_checkbox("Night", initial_value=False, hint="A dark page")
        self._legend = gui.add_html(html.legend(simulated=False))

        @self._night.on_update
        async def _(_: Any) -> None:
            configure_theme(gui, dark=bool(self._night.value))

    @property
    def handles(self) -> list[Any]:
        """Whose updates change what is drawn."""
        return [*self._boxes.values(), self._night]

    @property
    def layers(self) -> frozenset[str]:
        """Names of the overlays to draw."""
        return frozenset(name for name, box in self._boxes.items() if box.value)

    @property
    def night(self) -> bool:
        """Whether it is dark."""
        return bool(self._night.value)

    def show_legend(self, *, simulated: bool) -> None:
        """What the colours mean."""
        self._legend.content = html.legend(simulated=simulated)


def configure_theme(gui: viser.GuiApi, *, dark: bool) -> None:
    """The look of all tabs, or of one."""
    gui.configure_theme(
        control_width="medium",
        show_logo=False,
        show_share_button=False,
        brand_color=BRAND,
        dark_mode=dark,
    )
