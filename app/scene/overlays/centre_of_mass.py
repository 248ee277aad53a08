"""The centre of mass of the robot that is drawn solid."""

from __future__ import annotations

from collections.abc import Sequence

import viser

from app.motion import colours
from app.motion.clip import Track
from app.motion.frames import Frames
from app.scene.drawing import RootedOverlay
from app.scene.picture import Picture

_RADIUS = 0.018  # m


class CentreOfMass(RootedOverlay):
    """A ball."""

    name = "com"
    title = "Centre of mass"
    hint = "Of the whole robot, as the model or the simulation has it."
    at_first = True
    root = "/com-of-robot"

    def __init__(self, scene: viser.SceneApi) -> None:
        """See `Drawing`."""
        super().__init__(scene)
        self._ball: viser.IcosphereHandle | None = None

    def tracks(self, picture: Picture, frames: Frames) -> Sequence[Track]:
        """See `RootedOverlay.tracks`."""
        if self._ball is None:
            self._ball = self.scene.add_icosphere(
                "/com", _RADIUS, colours.COM, subdivisions=2, cast_shadow=False
            )
        return [Track((self._ball.name,), frames.com)]

    def show(self, *, visible: bool) -> None:
        """See `Drawing.show`."""
        if self._ball is not None:
            self._ball.visible = visible
