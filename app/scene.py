"""What one tab sees: the robot, and the overlays that belong to its motion.

The scene draws instants it is given; the player owns time.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import viser
from numpy.typing import NDArray

from app.overlays import (
    COM_COLOUR,
    PLANNED_COLOUR,
    RIGID_COLOUR,
    Ellipsoid,
    Forces,
    Target,
    Trails,
)
from app.replay import Replay
from llsrbm.robots import Robot
from llsrbm.robots.visuals import forward_kinematics, link_visuals

Array = NDArray[np.float64]

_BLOT = 0.3  # m, length of the dark patch under the robot


@lru_cache(maxsize=8)
def _meshes(robot: Robot) -> tuple[tuple[str, int, bytes], ...]:
    """(link, body index, glTF) of each body, made once for all tabs."""
    return tuple(
        (visual.link, visual.joint_id - 1, visual.mesh().export(file_type="glb"))
        for visual in link_visuals(robot)
    )


class Scene:
    """The nodes of one tab; to be used by one thread."""

    # Browser tests find controls by label. viser's scene tree has labels, too, made from the names
    # of nodes, so these avoid the words of the panel (a node "robot" would be found as "Robot").

    def __init__(self, client: viser.ClientHandle) -> None:
        """An empty floor."""
        self._client = client
        self._bodies: list[tuple[int, viser.GlbHandle]] = []
        self._replay: Replay | None = None
        self._show_ellipsoids = self._show_forces = self._show_trails = True
        scene = client.scene
        self._ground = scene.add_grid(
            "/ground",
            infinite_grid=True,
            cell_size=0.1,
            cell_color=(225, 228, 232),
            cell_thickness=0.6,
            section_size=0.5,
            section_color=(190, 195, 202),
            fade_distance=9.0,
            shadow_opacity=0.0,
        )
        # Instead of shadows, one blot under the robot: it tells how high the robot is.
        self._blot = scene.add_icosphere(
            "/blot", _BLOT, (30, 34, 40), scale=(1.0, 0.7, 0.005), opacity=0.22, visible=False
        )
        self._com = scene.add_icosphere("/com", 0.018, COM_COLOUR, visible=False)
        self._planned = Ellipsoid(client, "/ellipsoid/planned", PLANNED_COLOUR, surface=True)
        self._rigid = Ellipsoid(client, "/ellipsoid/srbm", RIGID_COLOUR, surface=False)
        self._trails = Trails(client)
        self._forces: Forces | None = None
        self._target: Target | None = None

    def show_robot(self, robot: Robot) -> None:
        """Replace the robot by this one, in its default posture; nothing of a plan stays."""
        position, wxyz = forward_kinematics(
            robot, robot.base_position[None], [[1.0, 0.0, 0.0, 0.0]], robot.posture[None, 7:]
        )
        with self._client.atomic():
            self._clear()
            for _, handle in self._bodies:
                handle.remove()
            self._bodies = [
                (
                    body,
                    self._client.scene.add_glb(
                        f"/links/{link}", glb, position=position[0, body], wxyz=wxyz[0, body]
                    ),
                )
                for link, body, glb in _meshes(robot)
            ]

    def show_replay(self, replay: Replay) -> None:
        """Draw what of a motion does not move; follow with `show_instant`."""
        with self._client.atomic():
            self._replay = replay
            if self._forces is None or self._target is None:
                motion = replay.motion
                self._forces = Forces(self._client, motion.contact_point.shape[1])
                self._target = Target(self._client, motion.foot_position.shape[1])
            self._target.draw(replay)
            self._trails.draw(replay)
            self._ground.position = (0.0, 0.0, min(replay.plan.jump.height, 0.0))
            self._com.visible = self._blot.visible = True
            self._apply_layers()

    def show_instant(self, time: float) -> None:
        """Move everything to an instant of the motion, s."""
        replay = self._replay
        if replay is None:
            return
        frame = replay.frame_at(time)
        com = replay.motion.com[frame]
        with self._client.atomic():
            for body, handle in self._bodies:
                handle.position = replay.body_position[frame, body]
                handle.wxyz = replay.body_wxyz[frame, body]
            self._com.position = com
            self._blot.position = (com[0], com[1], self._ground.position[2] + 0.002)
            self._blot.wxyz = replay.yaw_wxyz[frame]
            if self._show_ellipsoids:
                self._planned.move(com, replay.planned_wxyz[frame], replay.planned_axes[frame])
                self._rigid.move(com, replay.rigid_wxyz[frame], replay.rigid_axes)
            if self._show_forces and self._forces is not None:
                self._forces.move(replay, frame)

    def show_layers(self, *, ellipsoids: bool, forces: bool, trails: bool) -> None:
        """Choose what is drawn besides the robot; follow with `show_instant`."""
        self._show_ellipsoids, self._show_forces, self._show_trails = ellipsoids, forces, trails
        with self._client.atomic():
            self._apply_layers()

    def _apply_layers(self) -> None:
        there = self._replay is not None
        for ellipsoid in (self._planned, self._rigid):
            ellipsoid.show(visible=there and self._show_ellipsoids)
        self._trails.show(visible=there and self._show_trails)
        if self._forces is not None:
            self._forces.hide()

    def _clear(self) -> None:
        """Forget the motion, and the nodes whose number depends on the robot."""
        self._replay = None
        self._com.visible = self._blot.visible = False
        self._apply_layers()
        for overlay in (self._forces, self._target):
            if overlay is not None:
                overlay.remove()
        self._forces = self._target = None
