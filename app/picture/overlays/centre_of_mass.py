"""The centre of mass of the robot that is drawn solid."""

from __future__ import annotations

from collections.abc import Sequence

import viser

from app.motion import colours
from app.motion.clip import Strand, Track
from app.picture.drawing import Overlay
from app.picture.picture import Picture

_RADIUS = 0.018  # m


class CentreOfMass(Overlay):
    """A ball."""

    name = "com"
    title = "Centre of mass"
    hint = "Of the whole robot, as the model or the simulation has it."
    at_first = True

    def __init__(self, scene: viser.SceneApi) -> None:
        """See `Drawing`."""
        super().__init__(scene)
        self._ball: viser.IcosphereHandle | None = None

    def draw(self, picture: Picture) -> Sequence[Strand]:
        """See `Drawing.draw`."""
        frames = picture.solid
        assert frames is not None
        if self._ball is None:
            self._ball = self.scene.add_icosphere(
                "/com",
                _RADIUS,
                colours.COM,
                subdivisions=1,
                cast_shadow=False,
                receive_shadow=False,
            )
        return [Strand(frames.time, (Track((self._ball.name,), frames.com),))]

    def show(self, *, visible: bool) -> None:
        """See `Drawing.show`."""
        if self._ball is not None:
            self._ball.visible = visible
