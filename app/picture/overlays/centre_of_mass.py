"""The centre of mass of the robot that is drawn solid."""

from __future__ import annotations

from collections.abc import Sequence

import viser

from app.motion import colours
from app.motion.clip import AnimationChannel, Track
from app.picture.drawing import Key, Overlay
from app.picture.picture import Picture

_RADIUS = 0.018  # m


class CentreOfMass(Overlay):
    """A ball."""

    name = "com"
    title = "Centre of mass"
    hint = "Of the whole robot, as the model or the simulation has it."
    place = 20
    at_first = True

    _ball: viser.IcosphereHandle | None = None

    @classmethod
    def keys(cls, picture: Picture) -> Sequence[Key]:
        return [Key(colours.COM, "centre of mass")]

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        _, _, frames = picture.motion
        if self._ball is None:
            self._ball = self.scene.add_icosphere(
                "/com",
                _RADIUS,
                colours.COM,
                subdivisions=1,
                cast_shadow=False,
                receive_shadow=False,
            )
        return [AnimationChannel(frames.time, (Track((self._ball.name,), frames.com),))]

    def show(self, *, visible: bool) -> None:
        if self._ball is not None:
            self._ball.visible = visible
