"""What one tab sees: the robot, and the overlays that belong to its motion.

The scene draws instants it is given; the player owns time.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import viser
from numpy.typing import NDArray

from app import colours
from app.frames import Frames
from app.overlays import Blocks, Ellipsoid, Forces, Target, Trails, top_under
from app.replay import Replay
from app.robot_nodes import RobotNodes
from app.viewpoint import viewpoint
from llsrbm.robots import Robot
from llsrbm.simulation.surroundings import Block

Array = NDArray[np.float64]

_BLOT = 0.3  # m, length of the dark patch under the robot


class Scene:
    """The nodes of one tab; to be used by one thread.

    A plan alone is drawn solid. Beside a simulation it becomes a translucent ghost, made when it is
    needed first, and what moves with the robot moves with the simulated one.
    """

    # Browser tests find controls by label. viser's scene tree has labels, too, made from the names
    # of nodes, so these avoid the words of the panel (a node "robot" would be found as "Robot").

    def __init__(self, client: viser.ClientHandle) -> None:
        """An empty floor."""
        self._client = client
        self._robot: Robot | None = None
        self._solid: RobotNodes | None = None
        self._ghost: RobotNodes | None = None
        self._planned: Replay | None = None
        self._simulated: Frames | None = None
        self._around: Sequence[Block] = ()
        self._show_ellipsoids = self._show_forces = self._show_trails = self._show_ghost = True
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
        self._com = scene.add_icosphere("/com", 0.018, colours.COM, visible=False)
        self._model = Ellipsoid(client, "/ellipsoid/planned", colours.PLANNED, surface=True)
        # Two surfaces so close to each other would hide one another in turn.
        self._whole = Ellipsoid(client, "/ellipsoid/whole", colours.SIMULATED, surface=False)
        self._rigid = Ellipsoid(client, "/ellipsoid/srbm", colours.RIGID, surface=False)
        self._trails = Trails(client)
        self._blocks = Blocks(client)
        self._forces: Forces | None = None
        self._target: Target | None = None

    def show_robot(self, robot: Robot) -> None:
        """Replace the robot by this one, in its default posture, and look at it.

        Nothing of a plan stays.
        """
        with self._client.atomic():
            self._clear()
            for nodes in (self._solid, self._ghost):
                if nodes is not None:
                    nodes.remove()
            self._robot = robot
            self._solid = RobotNodes(self._client, robot, "/links")
            self._ghost = None
            # The position first: it takes along what is looked at.
            camera, (position, target) = self._client.camera, viewpoint(robot)
            camera.position, camera.look_at = position, target

    def show_motion(
        self, planned: Replay, simulated: Frames | None = None, blocks: Sequence[Block] = ()
    ) -> None:
        """Draw what of a motion does not move; follow with `show_instant`.

        Args:
            planned: the plan's.
            simulated: of the robot that followed it.
            blocks: what stands around it; of a plan alone, drawn as what it aims at.
        """
        assert self._robot is not None
        with self._client.atomic():
            self._planned, self._simulated, self._around = planned, simulated, blocks
            solid = simulated or planned.frames
            if self._forces is None or self._target is None:
                self._forces = Forces(self._client, len(self._robot.legs))
                self._target = Target(self._client, self._robot)
            if simulated is not None and self._ghost is None:
                self._ghost = RobotNodes(self._client, self._robot, "/shade", ghost=True)
            self._target.draw(planned.plan, blocks if simulated is None else ())
            self._blocks.draw(blocks if simulated is not None else ())
            self._trails.draw(solid, feasible=planned.plan.solved)
            self._ground.position = (0.0, 0.0, min(planned.plan.jump.height, 0.0))
            self._com.visible = self._blot.visible = True
            self._apply_layers()

    def show_instant(self, time: float) -> None:
        """Move everything to an instant of the motion, s."""
        planned = self._planned
        if planned is None or self._solid is None:
            return
        model, solid = planned.frames, self._simulated or planned.frames
        model_frame, frame = model.frame_at(time), solid.frame_at(time)
        com = solid.com[frame]
        with self._client.atomic():
            self._solid.move(solid, frame)
            if self._ghost is not None:
                self._ghost.move(model, model_frame)
            self._com.position = com
            below = top_under(self._around, com, time, self._ground.position[2])
            self._blot.position = (com[0], com[1], below + 0.002)
            self._blot.wxyz = solid.yaw_wxyz[frame]
            if self._show_ellipsoids:
                _move(self._model, model, model_frame)
                if self._simulated is not None:
                    _move(self._whole, solid, frame)
                else:
                    self._rigid.move(com, planned.rigid_wxyz[frame], planned.rigid_axes)
            if self._show_forces and self._forces is not None:
                self._forces.move(solid, frame)
            self._blocks.move(time)

    def show_layers(self, *, ellipsoids: bool, forces: bool, trails: bool, ghost: bool) -> None:
        """Choose what is drawn besides the robot; follow with `show_instant`."""
        self._show_ellipsoids, self._show_forces, self._show_trails = ellipsoids, forces, trails
        self._show_ghost = ghost
        with self._client.atomic():
            self._apply_layers()

    def _apply_layers(self) -> None:
        there, simulated = self._planned is not None, self._simulated is not None
        self._model.show(visible=there and self._show_ellipsoids)
        self._rigid.show(visible=there and not simulated and self._show_ellipsoids)
        self._whole.show(visible=simulated and self._show_ellipsoids)
        self._trails.show(visible=there and self._show_trails)
        if self._ghost is not None:
            self._ghost.show(visible=simulated and self._show_ghost)
        if self._forces is not None:
            self._forces.hide()

    def _clear(self) -> None:
        """Forget the motion, and the nodes whose number depends on the robot."""
        self._planned = self._simulated = None
        self._com.visible = self._blot.visible = False
        self._blocks.draw(())
        self._apply_layers()
        for overlay in (self._forces, self._target):
            if overlay is not None:
                overlay.remove()
        self._forces = self._target = None


def _move(ellipsoid: Ellipsoid, frames: Frames, frame: int) -> None:
    ellipsoid.move(frames.com[frame], frames.inertia_wxyz[frame], frames.inertia_axes[frame])
