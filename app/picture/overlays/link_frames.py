"""The axes of every link."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import viser

from app.motion.clip import Track
from app.motion.frames import Frames
from app.picture import gltf
from app.picture.drawing import Copies, RootedOverlay
from app.picture.picture import Picture

_LENGTH = 0.1  # m, of an axis


class LinkFrames(RootedOverlay):
    """Three short bars at the joint that moves a link; the base's at its origin."""

    name = "frames"
    title = "Link frames"
    hint = "Axes of the links, x red, y green, z blue, where the joints are that move them."
    root = "/axes"

    def __init__(self, scene: viser.SceneApi) -> None:
        """See `Drawing`."""
        super().__init__(scene)
        self._triads: Copies | None = None

    def tracks(self, picture: Picture, frames: Frames) -> Sequence[Track]:
        """See `RootedOverlay.tracks`."""
        self._triads = self._triads or Copies(self.scene, self.root, gltf.triad())
        size = np.full((len(frames.time), 3), _LENGTH)
        return [
            Track((name,), frames.body_position[:, body], frames.body_wxyz[:, body], size)
            for body, name in enumerate(self._triads.names(frames.body_position.shape[1]))
        ]
