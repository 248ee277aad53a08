"""How the robot turns as a whole."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.motion import colours
from app.motion.clip import Track
from app.motion.frames import Frames
from app.picture import gltf
from app.picture.drawing import Overlay
from app.picture.picture import Picture
from app.picture.turns import z_to

METRES_PER_UNIT = 0.1  # Length of the arrow of 1 kg m2/s, m

_TURNING = 0.05  # kg m2/s; less is not drawn
_WIDE = 1.5  # times as wide as a force's arrow


class AngularMomentum(Overlay):
    """An arrow from the CoM along the axis, by the right-hand rule."""

    name = "spin"
    title = "Angular momentum"
    hint = f"About the centre of mass; the arrow of 1 kg m²/s is {METRES_PER_UNIT:g} m long."
    place = 130
    root = "/momentum"

    def tracks(self, picture: Picture, frames: Frames) -> Sequence[Track]:
        amount = np.linalg.norm(frames.angular_momentum, axis=1)
        turning = amount > _TURNING
        along = np.where(turning[:, None], frames.angular_momentum, [0.0, 0.0, 1.0])
        wide = _WIDE * turning
        size = np.stack([wide, wide, turning * amount * METRES_PER_UNIT], axis=1)
        return [Track(tuple(self.nodes(gltf.arrow(colours.COM), 1)), frames.com, z_to(along), size)]
