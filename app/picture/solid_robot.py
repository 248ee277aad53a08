"""The robot itself, and a soft shadow below it that shows how high it is."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain, count

import numpy as np
import viser

from app.motion.clip import AnimationChannel, CameraTarget, Track
from app.picture import gltf
from app.picture.blocks import tops_under
from app.picture.drawing import Drawing
from app.picture.picture import Picture
from app.picture.robot_nodes import RobotNodes, RobotShelf, around, around_default

_EVERY = 4  # frames between those of which the box around a motion is made
_ABOVE_GROUND = 0.002  # m; a shadow would flicker in the ground's own plane
_LONG, _WIDE = 0.75, 0.62  # length and width of the shadow, in the robot's
_SPREADS = 0.5  # a shadow is larger by that share of its height above the ground, per m


class SolidRobot(Drawing):
    """Simulated, or planned, or in its default posture."""

    parts = frozenset({"robot", "planned", "simulated", "fine", "prepared"})
    needs_motion = False

    def __init__(self, scene: viser.SceneApi) -> None:
        super().__init__(scene)
        names = chain(["/links"], (f"/links-{number}" for number in count(2)))
        self._shelf = RobotShelf(scene, names)
        self._nodes: RobotNodes | None = None
        # what a camera looks at; None: there is no robot
        self.camera_target: CameraTarget | None = None

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        robot, frames = picture.robot, picture.solid
        if robot is None:
            self._nodes = self.camera_target = None
            self._shelf.show_only(())
            return ()
        nodes = self._nodes = self._shelf.take(robot, fine=picture.fine)
        self._shelf.show_only((nodes,))
        if frames is None:
            self.camera_target = CameraTarget(nodes.base, *around_default(robot))
            return [nodes.still()]
        box = around(robot, frames.body_position[::_EVERY], frames.body_wxyz[::_EVERY])
        self.camera_target = CameraTarget(nodes.base, *box)
        return [AnimationChannel(frames.time, tuple(nodes.track(frames)))]

    def show(self, *, visible: bool) -> None:
        """The robot is always seen."""


class ContactShadow(Drawing):
    """A soft disc on what is below the CoM, turned as the base is; a lamp's shadow comes on top."""

    parts = frozenset({"robot", "planned", "simulated", "blocks"})

    def __init__(self, scene: viser.SceneApi) -> None:
        super().__init__(scene)
        self._disc: viser.GlbHandle | None = None

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        robot, _, frames = picture.motion
        if self._disc is None:
            self._disc = self.scene.add_glb(
                "/below", gltf.soft_disc(), cast_shadow=False, receive_shadow=False
            )
        below = tops_under(picture.blocks, frames.com, frames.time, picture.ground)
        low, high = around_default(robot)
        half = (high - low)[:2] / 2 * [_LONG, _WIDE] * 2
        larger = 1 + _SPREADS * np.maximum(frames.com[:, 2] - below - robot.com[2], 0.0)
        size = np.column_stack([larger * half[0], larger * half[1], np.ones(len(larger))])
        position = np.column_stack([frames.com[:, :2], below + _ABOVE_GROUND])
        track = Track((self._disc.name,), position, frames.yaw_wxyz, size)
        return [AnimationChannel(frames.time, (track,))]

    def show(self, *, visible: bool) -> None:
        if self._disc is not None:
            self._disc.visible = visible
