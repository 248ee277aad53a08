"""What is drawn besides the robot, and in which light."""

from __future__ import annotations

from typing import Any

import viser

from app.panel import html

BRAND = (38, 92, 150)


class ViewControls:
    """Boxes to tick and the legend, added to the folder that is open."""

    def __init__(self, gui: viser.GuiApi) -> None:
        """Everything is drawn, on a light ground."""
        self._gui = gui
        self._ellipsoids = gui.add_checkbox("Inertia ellipsoids", initial_value=True)
        self._forces = gui.add_checkbox("Forces", initial_value=True)
        self._trails = gui.add_checkbox("Trails", initial_value=True)
        self._ghost = gui.add_checkbox(
            "Ghost", initial_value=True, hint="The plan beside its simulation, and what is pinned"
        )
        self._target = gui.add_checkbox(
            "Landing handle", initial_value=True, hint="Drag it in the picture to move the landing"
        )
        self._dark = gui.add_checkbox("Night", initial_value=False, hint="A dark page")
        self._legend = gui.add_html(html.legend(simulated=False))

        @self._dark.on_update
        async def _(_: Any) -> None:
            configure_theme(gui, dark=bool(self._dark.value))

    @property
    def handles(self) -> list[Any]:
        """Whose updates change what is drawn."""
        return [self._ellipsoids, self._forces, self._trails, self._ghost, self._target, self._dark]

    def read(self) -> dict[str, bool]:
        """What to draw, as arguments of `Stage.show_layers`."""
        return {
            "ellipsoids": bool(self._ellipsoids.value),
            "forces": bool(self._forces.value),
            "trails": bool(self._trails.value),
            "ghost": bool(self._ghost.value),
            "target": bool(self._target.value),
            "dark": bool(self._dark.value),
        }

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
