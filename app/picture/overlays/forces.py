"""An arrow a foot, from where the force acts along the force."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.motion import colours
from app.motion.clip import Track
from app.motion.frames import Frames
from app.picture import gltf
from app.picture.drawing import Key, Overlay
from app.picture.picture import Picture
from app.picture.turns import z_to

ARROW_PER_WEIGHT = 0.8  # Length of the arrow of a force as large as the robot's weight, m

_PUSHING = 1.0  # N; smaller forces are not drawn


class Forces(Overlay):
    """The sum of a foot's contact forces; none where a foot hardly pushes."""

    name = "forces"
    title = "Forces"
    hint = f"Contact forces; one as large as the robot's weight is {ARROW_PER_WEIGHT:g} m long."
    place = 30
    at_first = True
    root = "/arrows"

    @classmethod
    def keys(cls, picture: Picture) -> Sequence[Key]:
        kind = "planned" if picture.rollout is None else "measured"
        meaning = f"contact forces, {kind}; the weight is {ARROW_PER_WEIGHT:g}\u00a0m long"
        return [Key(colours.FORCE, meaning)]

    def tracks(self, picture: Picture, frames: Frames) -> Sequence[Track]:
        length = np.linalg.norm(frames.foot_force, axis=2)
        pushing = length > _PUSHING
        along = np.where(pushing[..., None], frames.foot_force, [0.0, 0.0, 1.0])
        long = np.where(pushing, length * ARROW_PER_WEIGHT / frames.weight, 0.0)
        wide = pushing.astype(float)
        return [
            Track(
                (name,),
                frames.pressed_at[:, foot],
                z_to(along[:, foot]),
                np.stack([wide[:, foot], wide[:, foot], long[:, foot]], axis=1),
            )
            for foot, name in enumerate(self.nodes(gltf.arrow(colours.FORCE), length.shape[1]))
        ]
