"""What one tab sees: the robot, its inertia, forces, trails, where it shall land.

The scene draws instants it is given; the player owns time.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Protocol

import numpy as np
import viser
from numpy.typing import NDArray

from app.replay import Replay
from llsrbm.robots import Robot
from llsrbm.robots.visuals import forward_kinematics, link_visuals
from llsrbm.trajectory.plan import Phase

Array = NDArray[np.float64]
Rgb = tuple[int, int, int]

PLANNED_COLOUR: Rgb = (44, 123, 229)
RIGID_COLOUR: Rgb = (240, 140, 30)
FORCE_COLOUR: Rgb = (214, 51, 108)
COM_COLOUR: Rgb = (90, 60, 180)
FOOT_COLOUR: Rgb = (110, 120, 130)
TARGET_COLOUR: Rgb = (40, 160, 90)
_INFEASIBLE_COLOUR: Rgb = (220, 40, 40)

ARROW_PER_WEIGHT = 0.8
"""Length of the arrow of a force as large as the robot's weight, m."""

_BLOT = 0.3  # m, length of the dark patch under the robot
_OUTSIDE = 1.004  # a wireframe must lie just outside of a surface to be seen
_FOOTPRINT = 0.03  # m, radius of a landing mark
_ALONG_TRAIL = 4  # frames between the points of a trail


class _Hideable(Protocol):
    visible: bool


@lru_cache(maxsize=8)
def _meshes(robot: Robot) -> tuple[tuple[str, int, bytes], ...]:
    """(link, body index, glTF) of each body, made once for all tabs."""
    return tuple(
        (visual.link, visual.joint_id - 1, visual.mesh().export(file_type="glb"))
        for visual in link_visuals(robot)
    )


class _Ellipsoid:
    """A unit sphere, a wireframe with or without a translucent surface, moved and stretched."""

    def __init__(
        self, client: viser.ClientHandle, name: str, colour: Rgb, *, surface: bool
    ) -> None:
        scene = client.scene
        # A node's scale does not reach its children: only pose and visibility do.
        self._frame = scene.add_frame(name, show_axes=False, visible=False)
        self._axes = np.ones(3)
        self._spheres = [
            scene.add_icosphere(
                f"{name}/wires", _OUTSIDE, colour, wireframe=True, opacity=0.35, cast_shadow=False
            )
        ]
        if surface:
            self._spheres.append(
                scene.add_icosphere(f"{name}/surface", 1.0, colour, opacity=0.22, cast_shadow=False)
            )

    def move(self, position: Array, wxyz: Array, axes: Array) -> None:
        self._frame.position = position
        self._frame.wxyz = wxyz
        if not np.allclose(axes, self._axes, atol=1e-4):
            self._axes = axes
            for sphere in self._spheres:
                sphere.scale = (float(axes[0]), float(axes[1]), float(axes[2]))

    def show(self, *, visible: bool) -> None:
        self._frame.visible = visible


class Scene:
    """The nodes of one tab; to be used by one thread."""

    def __init__(self, client: viser.ClientHandle) -> None:
        """An empty floor."""
        self._client = client
        self._robot: Robot | None = None
        self._bodies: list[tuple[int, viser.GlbHandle]] = []
        self._plan_nodes: list[viser.SceneNodeHandle] = []
        self._replay: Replay | None = None
        self._shown_interval = -1
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
        self._planned = _Ellipsoid(client, "/ellipsoid/planned", PLANNED_COLOUR, surface=True)
        self._rigid = _Ellipsoid(client, "/ellipsoid/srbm", RIGID_COLOUR, surface=False)
        self._com = scene.add_icosphere("/com", 0.018, COM_COLOUR, visible=False)
        self._forces: viser.ArrowsHandle | None = None
        self._trails: list[_Hideable] = []

    # ---- what there is

    def show_robot(self, robot: Robot) -> None:
        """Replace the robot by this one, in its default posture; nothing of a plan stays."""
        with self._client.atomic():
            self._clear_plan()
            for _, handle in self._bodies:
                handle.remove()
            self._robot = robot
            position, wxyz = forward_kinematics(
                robot, robot.base_position[None], _level(), robot.posture[None, 7:]
            )
            self._bodies = [
                (
                    body,
                    self._client.scene.add_glb(
                        f"/links/{link}",
                        glb,
                        position=position[0, body],
                        wxyz=wxyz[0, body],
                        receive_shadow=False,
                    ),
                )
                for link, body, glb in _meshes(robot)
            ]

    def show_replay(self, replay: Replay) -> None:
        """Draw what of a motion does not move; follow with `show_instant`."""
        assert self._robot is not None
        with self._client.atomic():
            self._clear_plan()
            self._replay = replay
            self._draw_targets(replay)
            self._draw_trails(replay)
            self._draw_forces(replay)
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
            if self._show_forces:
                self._update_forces(replay, frame)

    def show_layers(self, *, ellipsoids: bool, forces: bool, trails: bool) -> None:
        """Choose what is drawn besides the robot; follow with `show_instant`."""
        self._show_ellipsoids, self._show_forces, self._show_trails = ellipsoids, forces, trails
        with self._client.atomic():
            self._apply_layers()

    # ---- parts

    def _draw_targets(self, replay: Replay) -> None:
        """Marks where the feet shall land, and the step up or down as a translucent block."""
        plan, scene = replay.plan, self._client.scene
        landing = plan.foot_position[-1]
        for i, foot in enumerate(landing):
            self._plan_nodes.append(
                scene.add_cylinder(
                    f"/target/foot{i}",
                    _FOOTPRINT,
                    0.004,
                    TARGET_COLOUR,
                    position=(foot[0], foot[1], plan.jump.height + 0.003),
                    cast_shadow=False,
                )
            )
        height = plan.jump.height
        self._ground.position = (0.0, 0.0, min(height, 0.0))
        if height == 0:
            return
        feet = landing if height > 0 else plan.foot_position[0]
        low, high = feet[:, :2].min(axis=0) - 0.12, feet[:, :2].max(axis=0) + 0.12
        centre = (low + high) / 2
        self._plan_nodes.append(
            scene.add_box(
                "/target/step",
                TARGET_COLOUR if height > 0 else FOOT_COLOUR,
                (high[0] - low[0], high[1] - low[1], abs(height)),
                position=(centre[0], centre[1], height / 2),
                opacity=0.22,
                cast_shadow=False,
            )
        )

    def _draw_trails(self, replay: Replay) -> None:
        plan, motion, scene = replay.plan, replay.motion, self._client.scene
        kept = np.r_[0 : len(motion.time) - 1 : _ALONG_TRAIL, len(motion.time) - 1]
        trails = [
            scene.add_spline_catmull_rom(
                "/path/com",
                motion.com[kept],
                thickness=0.008,
                color=COM_COLOUR if plan.solved else _INFEASIBLE_COLOUR,
            )
        ]
        flight = kept[motion.phase[kept] == Phase.FLIGHT]
        if len(flight) > 1:
            trails += [
                scene.add_spline_catmull_rom(
                    f"/path/foot{i}",
                    motion.foot_position[flight, i],
                    thickness=0.004,
                    color=FOOT_COLOUR,
                )
                for i in range(motion.foot_position.shape[1])
            ]
        self._trails = list(trails)
        self._plan_nodes += trails

    def _draw_forces(self, replay: Replay) -> None:
        contacts = replay.motion.contact_point.shape[1]
        self._forces = self._client.scene.add_arrows(
            "/arrows",
            np.zeros((contacts, 2, 3), dtype=np.float32),
            FORCE_COLOUR,
            shaft_radius=0.008,
            head_radius=0.02,
            head_length=0.04,
            visible=False,
        )
        self._plan_nodes.append(self._forces)
        self._shown_interval = -1

    def _update_forces(self, replay: Replay, frame: int) -> None:
        """Only when they change: they are constant over an interval of the plan."""
        assert self._forces is not None
        assert self._robot is not None
        interval = int(replay.interval[frame])
        if interval == self._shown_interval:
            return
        self._shown_interval = interval
        force = replay.motion.contact_force[frame]
        pushing = bool(np.abs(force).max() > 1.0)
        if pushing:
            foot = replay.motion.contact_point[frame]
            arrow = force * (ARROW_PER_WEIGHT / (self._robot.mass * 9.81))
            self._forces.points = np.stack([foot, foot + arrow], axis=1).astype(np.float32)
        self._forces.visible = pushing

    def _apply_layers(self) -> None:
        there = self._replay is not None
        for ellipsoid in (self._planned, self._rigid):
            ellipsoid.show(visible=there and self._show_ellipsoids)
        for trail in self._trails:
            trail.visible = self._show_trails
        if self._forces is not None:
            self._forces.visible = False
        self._shown_interval = -1

    def _clear_plan(self) -> None:
        for node in self._plan_nodes:
            node.remove()
        self._plan_nodes.clear()
        self._trails = []
        self._forces = None
        self._replay = None
        self._com.visible = self._blot.visible = False
        self._apply_layers()


def _level() -> Array:
    return np.array([[1.0, 0.0, 0.0, 0.0]])
