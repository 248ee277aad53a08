"""The axes of every link."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.motion.clip import Track
from app.motion.frames import Frames
from app.picture import gltf
from app.picture.drawing import Overlay
from app.picture.picture import Picture

_LENGTH = 0.1  # m, of an axis


class LinkFrames(Overlay):
    """Three short bars at the joint that moves a link; the base's at its origin."""

    name = "frames"
    title = "Link frames"
    hint = "Axes of the links, x red, y green, z blue, where the joints are that move them."
    place = 150
    root = "/axes"

    def tracks(self, picture: Picture, frames: Frames) -> Sequence[Track]:
        size = np.full((len(frames.time), 3), _LENGTH)
        return [
            Track((name,), frames.body_position[:, body], frames.body_wxyz[:, body], size)
            for body, name in enumerate(self.nodes(gltf.triad(), frames.body_position.shape[1]))
        ]
