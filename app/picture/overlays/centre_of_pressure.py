"""Where the force of the ground acts, all feet together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from app.motion import colours
from app.motion.clip import Track
from app.motion.frames import Frames
from app.picture import gltf
from app.picture.drawing import Overlay
from app.picture.picture import Picture

Array = NDArray[np.float64]

_RADIUS, _THICK = 0.022, 0.02  # m; thickness: stretches a disc of 0.2
_ABOVE = 0.003  # m
_LOADED = 0.02  # of the weight; with less, feet hardly stand


class CentreOfPressure(Overlay):
    """A disc; none in flight. A simulation does not record where in a sole its force acts."""

    name = "pressure"
    title = "Centre of pressure"
    hint = "Where the ground's whole force acts: the feet, weighted by the load that they carry."
    place = 120
    root = "/zmp"

    def tracks(self, picture: Picture, frames: Frames) -> Sequence[Track]:
        place, there = centre_of_pressure(frames)
        return [
            Track(
                tuple(self.nodes(gltf.disc(colours.FORCE), 1)),
                place + np.array([0.0, 0.0, _ABOVE]),
                None,
                there[:, None] * np.array([_RADIUS, _RADIUS, _THICK]),
            )
        ]


def centre_of_pressure(frames: Frames) -> tuple[Array, NDArray[np.bool_]]:
    """(F, 3) m, and (F,) whether there is one: in flight it is below the CoM, and none."""
    load = np.maximum(frames.foot_force[..., 2], 0.0)
    total = load.sum(axis=1)
    there = total > _LOADED * frames.weight
    share = load / np.where(there, total, 1.0)[:, None]
    place = np.einsum("fl,fli->fi", share, frames.pressed_at)
    away = frames.com * [1.0, 1.0, 0.0]
    return np.where(there[:, None], place, away), there
