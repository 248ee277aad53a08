"""Translucent robots: the plan beside its simulation, and pinned motions."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain, count

import viser

from app.motion import colours
from app.motion.clip import AnimationChannel
from app.picture.drawing import Key, Overlay
from app.picture.picture import Picture
from app.picture.robot_nodes import RobotNodes, RobotShelf


class Ghosts(Overlay):
    """Each with a time of its own."""

    name = "ghost"
    title = "Ghost"
    hint = "The plan beside its simulation, and what is pinned."
    place = 50
    at_first = True
    parts = frozenset({"robot", "planned", "simulated", "ghosts", "prepared"})
    needs_motion = False

    def __init__(self, scene: viser.SceneApi) -> None:
        super().__init__(scene)
        names = chain(["/shade"], (f"/shade-{number}" for number in count(2)))
        self._plans = RobotShelf(scene, names)
        self._pins = RobotShelf(scene, (f"/pinned/{number}" for number in count(1)))
        self._plan: list[RobotNodes] = []
        self._pinned: list[RobotNodes] = []

    @classmethod
    def keys(cls, picture: Picture) -> Sequence[Key]:
        if picture.rollout is None:
            return []
        return [Key(colours.PLANNED, "the plan, a ghost beside the simulated robot")]

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        self._plan, self._pinned = [], []
        channels = []
        for ghost in picture.ghosts:
            nodes = self._pins.take(ghost.robot, ghost=ghost.colour)
            self._pinned.append(nodes)
            channels.append(AnimationChannel(ghost.frames.time, tuple(nodes.track(ghost.frames))))
        if picture.robot is not None and picture.planned is not None and picture.simulated:
            nodes = self._plans.take(picture.robot, ghost=colours.PLANNED)
            self._plan.append(nodes)
            frames = picture.planned.frames
            channels.append(AnimationChannel(frames.time, tuple(nodes.track(frames))))
        return channels

    def show(self, *, visible: bool) -> None:
        self._plans.show_only(self._plan if visible else ())
        self._pins.show_only(self._pinned if visible else ())
