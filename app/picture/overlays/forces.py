"""Forces of the ground: arrows, where they must stay, where they act together; and the momentum."""

from collections.abc import Sequence

import numpy as np

from app.motion import colours
from app.motion.clip import Track
from app.picture import gltf
from app.picture.drawing import Group, Overlay
from app.picture.picture import Picture
from llsrbm.arrays import Array, BoolArray
from llsrbm.look.shown_motion import ARROW_PER_WEIGHT, ShownMotion
from llsrbm.mechanics import INSCRIBED, turned_to


class Forces(Overlay):
    """The sum of a foot's contact forces; none where a foot hardly pushes."""

    name = "forces"
    group = Group.FORCES
    title = "Forces"
    hint = f"Contact forces; one as large as the robot's weight is {ARROW_PER_WEIGHT:g} m long."
    place = 30
    tints = (colours.FORCE,)
    at_first = True
    common = True
    root = "/arrows"

    def tracks(self, picture: Picture, frames: ShownMotion) -> Sequence[Track]:
        arrows = frames.arrows
        long = np.linalg.norm(arrows, axis=2)
        wide = (long > 0).astype(float)
        return [
            Track(
                (name,),
                frames.pressed_at[:, foot],
                turned_to(arrows[:, foot], 2),
                np.stack([wide[:, foot], wide[:, foot], long[:, foot]], axis=1),
            )
            for foot, name in enumerate(self.nodes(gltf.arrow(colours.FORCE), long.shape[1]))
        ]


_HEIGHT = 0.16  # m


class FrictionPyramids(Overlay):
    """Pyramids, since planner and controller keep to the one that is inscribed in the cone.

    Its edges lie in the cone; its sides look along the world's axes, as in the constraint.
    """

    name = "friction"
    group = Group.FORCES
    title = "Friction pyramids"
    hint = "A standing foot's force stays in this pyramid, inscribed in the plan's friction cone."
    place = 100
    tints = (colours.FRICTION,)
    root = "/pyramids"

    def tracks(self, picture: Picture, frames: ShownMotion) -> Sequence[Track]:
        _, planned, _ = picture.motion
        half = _HEIGHT * INSCRIBED * planned.plan.friction
        size = np.array([half, half, _HEIGHT])
        names = self.nodes(gltf.pyramid(colours.FRICTION, 0.35), frames.contact.shape[1])
        return [
            # From where the force acts, so that its arrow is seen to stay inside.
            Track((name,), frames.pressed_at[:, foot], None, frames.contact[:, foot, None] * size)
            for foot, name in enumerate(names)
        ]


_RADIUS, _THICK = 0.022, 0.02  # m; thickness: stretches a disc of 0.2
_ABOVE = 0.003  # m
_LOADED = 0.02  # of the weight; with less, feet hardly stand


class CentreOfPressure(Overlay):
    """A disc; none in flight. A simulation does not record where in a sole its force acts."""

    name = "pressure"
    group = Group.FORCES
    title = "Centre of pressure"
    hint = "Point where the resultant ground force acts: the feet, weighted by their loads."
    place = 120
    tints = (colours.FORCE,)
    root = "/zmp"

    def tracks(self, picture: Picture, frames: ShownMotion) -> Sequence[Track]:
        place, there = centre_of_pressure(frames)
        return [
            Track(
                tuple(self.nodes(gltf.disc(colours.FORCE), 1)),
                place + np.array([0.0, 0.0, _ABOVE]),
                None,
                there[:, None] * np.array([_RADIUS, _RADIUS, _THICK]),
            )
        ]


def centre_of_pressure(frames: ShownMotion) -> tuple[Array, BoolArray]:
    """(F, 3) m, and (F,) whether there is one: in flight it is below the CoM, and none."""
    load = np.maximum(frames.foot_force[..., 2], 0.0)
    total = load.sum(axis=1)
    there = total > _LOADED * frames.weight
    share = load / np.where(there, total, 1.0)[:, None]
    place = np.einsum("fl,fli->fi", share, frames.pressed_at)
    away = frames.com * [1.0, 1.0, 0.0]
    return np.where(there[:, None], place, away), there


METRES_PER_UNIT = 0.1  # Length of the arrow of 1 kg m2/s, m

_TURNING = 0.05  # kg m2/s; less is not drawn
_WIDE = 1.5  # times as wide as a force's arrow


class AngularMomentum(Overlay):
    """An arrow from the CoM along the axis, by the right-hand rule."""

    name = "spin"
    group = Group.INERTIA
    title = "Angular momentum"
    hint = f"About the centre of mass; the arrow of 1 kg m²/s is {METRES_PER_UNIT:g} m long."
    place = 130
    tints = (colours.COM,)
    root = "/momentum"

    def tracks(self, picture: Picture, frames: ShownMotion) -> Sequence[Track]:
        amount = np.linalg.norm(frames.angular_momentum, axis=1)
        turning = amount > _TURNING
        wide = _WIDE * turning
        size = np.stack([wide, wide, turning * amount * METRES_PER_UNIT], axis=1)
        nodes = tuple(self.nodes(gltf.arrow(colours.COM), 1))
        return [Track(nodes, frames.com, turned_to(frames.angular_momentum, 2), size)]
