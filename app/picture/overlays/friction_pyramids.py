"""Where the forces of standing feet must stay."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.motion import colours
from app.motion.clip import Track
from app.motion.frames import Frames
from app.picture import gltf
from app.picture.drawing import Overlay
from app.picture.picture import Picture
from llsrbm.mechanics import INSCRIBED
from llsrbm.motion.plan import Plan

_HEIGHT = 0.16  # m


class FrictionPyramids(Overlay):
    """Pyramids, since planner and controller keep to the one that is inscribed in the cone.

    Its edges lie in the cone; its sides look along the world's axes, as in the constraint.
    """

    name = "friction"
    title = "Friction pyramids"
    hint = "A standing foot's force stays inside: the pyramid in the cone of the plan's friction."
    place = 100
    root = "/pyramids"

    def tracks(self, picture: Picture, frames: Frames) -> Sequence[Track]:
        _, planned, _ = picture.motion
        half = _HEIGHT * INSCRIBED * friction_of(planned.plan)
        size = np.array([half, half, _HEIGHT])
        names = self.nodes(gltf.pyramid(colours.FRICTION, 0.35), frames.contact.shape[1])
        return [
            # From where the force acts, so that its arrow is seen to stay inside.
            Track((name,), frames.pressed_at[:, foot], None, frames.contact[:, foot, None] * size)
            for foot, name in enumerate(names)
        ]


def friction_of(plan: Plan) -> float:
    """The coefficient that a plan was made with: its robot's, or the tuning's."""
    own = plan.robot_parameters["limits"]["friction"]
    return float(plan.tuning.limits.get("friction", own))
