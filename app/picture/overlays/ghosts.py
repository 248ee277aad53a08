"""Translucent robots: the plan beside its simulation, and pinned motions.

A ghost is drawn, the whole of it, only while a part of it is away from the solid robot's: two
surfaces in nearly the same place flicker through each other.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain, count

import numpy as np
import viser
from scipy.ndimage import maximum_filter1d

from app.motion import colours
from app.motion.clip import AnimationChannel
from app.motion.colours import Rgb
from app.picture.bounds import apart
from app.picture.drawing import Group, Meaning, Overlay
from app.picture.picture import Picture
from app.picture.robot_nodes import RobotNodes, RobotShelf
from llsrbm.look.shown_motion import ShownMotion

_DIFFERS = 0.02  # m between a body and the same body of the solid robot
_AROUND = 9  # frames; a ghost that differs is also drawn for a moment before and after


class Ghosts(Overlay):
    """Each with a time of its own."""

    name = "ghost"
    root = "/shade"
    group = Group.INERTIA
    title = "Ghost"
    hint = "The plan beside its simulation, and what is pinned, while a part of it is 2 cm away."
    place = 50
    at_first = True
    common = True
    parts = frozenset({"robot", "planned", "simulated", "ghosts", "prepared", "row"})
    needs_motion = False

    @classmethod
    def swatch(cls, picture: Picture) -> Sequence[Rgb]:
        plan = [] if picture.simulated is None else [colours.PLANNED]
        return [*plan, *(ghost.colour for ghost in picture.ghosts)]

    @classmethod
    def legend(cls, picture: Picture) -> Sequence[Meaning]:
        return [] if picture.simulated is None else [(colours.PLANNED, "plan, as a ghost")]

    def __init__(self, scene: viser.SceneApi) -> None:
        super().__init__(scene)
        names = chain(["/shade"], (f"/shade-{number}" for number in count(2)))
        self._plans = RobotShelf(scene, names)
        self._pins = RobotShelf(scene, (f"/pinned/{number}" for number in count(1)))
        self._plan: list[RobotNodes] = []
        self._pinned: list[RobotNodes] = []

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        self._plan, self._pinned = [], []
        channels = []
        for ghost in picture.ghosts:
            nodes = self._pins.take(ghost.robot, ghost=ghost.colour)
            self._pinned.append(nodes)
            channels.append(_beside(picture, nodes, ghost.frames))
        planned = None if picture.row else picture.planned
        if picture.robot is not None and planned is not None and picture.simulated:
            nodes = self._plans.take(picture.robot, ghost=colours.PLANNED)
            self._plan.append(nodes)
            channels.append(_beside(picture, nodes, planned.frames))
        return channels

    def show(self, *, visible: bool) -> None:
        self._plans.show_only(self._plan if visible else ())
        self._pins.show_only(self._pinned if visible else ())


def _beside(picture: Picture, nodes: RobotNodes, frames: ShownMotion) -> AnimationChannel:
    """A ghost's motion; it has no size while the solid robot is in the same place."""
    solid, tracks = picture.solid, nodes.track(frames)
    if solid is None or nodes.robot is not picture.robot:
        return AnimationChannel(frames.time, tuple(tracks))
    # The ghost rests at its end while the solid robot goes on.
    time = np.concatenate([frames.time, solid.time[solid.time > frames.end]])
    frame = np.arange(len(time)).clip(max=len(frames.time) - 1)
    differs = (apart(nodes.robot, frames, solid, time) > _DIFFERS).any(axis=1)
    there = np.repeat(maximum_filter1d(differs.astype(float), _AROUND)[:, None], 3, axis=1)
    return AnimationChannel(
        time,
        tuple(
            replace(
                track,
                position=track.position[frame],
                wxyz=None if track.wxyz is None else track.wxyz[frame],
                scale=there,
            )
            for track in tracks
        ),
    )
