"""What one tab sees: the robot, and the overlays that belong to its motion.

The scene makes nodes and says how they move, as a clip; a player moves them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import viser
from numpy.typing import NDArray

from app.motion import colours
from app.motion.clip import Clip, Strand, Track
from app.motion.colours import Rgb
from app.motion.frames import Frames
from app.motion.planned_motion import PlannedMotion
from app.scene.overlays import Blocks, Ellipsoid, Forces, Nodes, Target, Trails, tops_under
from app.scene.picture import Ghost
from app.scene.robot_nodes import RobotNodes
from llsrbm.robots import Robot
from llsrbm.robots.viewpoint import viewpoint
from llsrbm.simulation.surroundings import Block

Array = NDArray[np.float64]

_BLOT = 0.3  # m, length of the dark patch under the robot
_GRID: dict[bool, tuple[Rgb, Rgb]] = {
    False: ((225, 228, 232), (190, 195, 202)),
    True: ((52, 56, 62), (84, 90, 98)),
}
"""Dark or not -> colours of the ground's lines, of 0.1 m and 0.5 m."""
_ABOVE_GROUND = 0.002  # m; the patch would flicker in the ground's own plane


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
        self._fine = False
        self._robot: Robot | None = None
        self._solid: RobotNodes | None = None
        self._shade: RobotNodes | None = None
        self._ghosts: list[tuple[Ghost, RobotNodes]] = []
        self._ghosts_made = 0
        self._planned: PlannedMotion | None = None
        self._simulated: Frames | None = None
        self._around: Sequence[Block] = ()
        self._show_ellipsoids = self._show_forces = self._show_trails = self._show_ghost = True
        scene = client.scene
        self._ground = scene.add_grid(
            "/ground",
            infinite_grid=True,
            cell_size=0.1,
            cell_color=_GRID[False][0],
            cell_thickness=0.6,
            section_size=0.5,
            section_color=_GRID[False][1],
            fade_distance=9.0,
            shadow_opacity=0.0,
        )
        # Instead of shadows, one blot under the robot: it tells how high the robot is.
        self._blot = scene.add_icosphere(
            "/blot",
            _BLOT,
            (30, 34, 40),
            subdivisions=2,
            scale=(1.0, 0.7, 0.005),
            opacity=0.22,
            visible=False,
        )
        self._com = scene.add_icosphere("/com", 0.018, colours.COM, subdivisions=2, visible=False)
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

        Nothing of a motion stays but the pinned ones.
        """
        with self._client.atomic():
            self._clear()
            for nodes in (self._solid, self._shade):
                if nodes is not None:
                    nodes.remove()
            self._robot = robot
            self._solid = RobotNodes(self._client, robot, "/links", fine=self._fine)
            self._shade = None
            # The position first: it takes along what is looked at.
            camera, (position, target) = self._client.camera, viewpoint(robot)
            camera.position, camera.look_at = position, target

    def show_motion(
        self, planned: PlannedMotion, simulated: Frames | None = None, blocks: Sequence[Block] = ()
    ) -> None:
        """Draw what of a motion does not move; the `clip` says how the rest does.

        Args:
            planned: the plan's.
            simulated: of the robot that followed it.
            blocks: what stands around it; of a plan alone, drawn as what it aims at.
        """
        assert self._robot is not None
        with self._client.atomic():
            self._planned, self._simulated, self._around = planned, simulated, blocks
            if self._forces is None or self._target is None:
                self._forces = Forces(self._client, len(self._robot.legs))
                self._target = Target(self._client, self._robot)
            if simulated is not None and self._shade is None:
                self._shade = RobotNodes(self._client, self._robot, "/shade", ghost=colours.PLANNED)
            self._target.draw(planned.plan, blocks if simulated is None else ())
            self._blocks.draw(blocks if simulated is not None else ())
            self._trails.draw(simulated or planned.frames, feasible=planned.plan.solved)
            self._ground.position = (0.0, 0.0, min(planned.plan.jump.height, 0.0))
            self._com.visible = self._blot.visible = True
            self._apply_layers()

    def show_ghosts(self, ghosts: Sequence[Ghost]) -> None:
        """Draw these pinned motions and no others; follow with the `clip`."""
        with self._client.atomic():
            for ghost, nodes in self._ghosts:
                if ghost not in ghosts:
                    nodes.remove()
            kept = {id(ghost): nodes for ghost, nodes in self._ghosts}
            self._ghosts = [(ghost, kept.get(id(ghost)) or self._ghost(ghost)) for ghost in ghosts]
            self._apply_layers()

    def clip(self) -> Clip:
        """How everything moves that is shown."""
        strands = [
            Strand(ghost.frames.time, tuple(nodes.track(ghost.frames)))
            for ghost, nodes in self._ghosts
        ]
        planned, simulated = self._planned, self._simulated
        if planned is None or self._solid is None:
            return Clip((), 0.0)
        solid = simulated or planned.frames
        moving = [*self._solid.track(solid), *self._with_the_robot(solid)]
        model = Strand(planned.frames.time, (_ellipsoid(self._model, planned.frames),))
        if simulated is not None:
            assert self._shade is not None
            model = Strand(model.time, (*model.tracks, *self._shade.track(planned.frames)))
            moving.append(_ellipsoid(self._whole, simulated))
        else:
            frames = planned.frames
            axes = np.broadcast_to(planned.rigid_axes, frames.com.shape)
            moving.append(self._rigid.track(frames.com, planned.rigid_wxyz, axes))
        strands += [model, Strand(solid.time, tuple(moving))]
        end = max(float(strand.time[-1]) for strand in strands)
        return Clip(tuple(strands), end, planned.plan.jump.as_dict())

    def show_instant(self, clip: Clip, time: float) -> None:
        """Move everything to an instant of a clip, s, from here."""
        nodes = self._nodes()
        with self._client.atomic():
            for strand in clip.strands:
                frame = strand.frame_at(time)
                for track in strand.tracks:
                    for handle in (nodes[name] for name in track.nodes if name in nodes):
                        handle.position = track.position[frame]
                        if track.wxyz is not None:
                            handle.wxyz = track.wxyz[frame]
                        if track.scale is not None:
                            handle.scale = tuple(map(float, track.scale[frame]))

    def refine(self) -> None:
        """Draw robots with all triangles from now on: the browser has a graphics processor."""
        self._fine = True
        if self._solid is not None:
            with self._client.atomic():
                self._solid.refine()

    def show_layers(
        self, *, ellipsoids: bool, forces: bool, trails: bool, ghost: bool, dark: bool
    ) -> None:
        """Choose what is drawn besides the robot, and whether the ground is dark."""
        self._show_ellipsoids, self._show_forces, self._show_trails = ellipsoids, forces, trails
        self._show_ghost = ghost
        cells, sections = _GRID[dark]
        with self._client.atomic():
            self._ground.cell_color, self._ground.section_color = cells, sections
            self._apply_layers()

    # ---- inside

    def _with_the_robot(self, solid: Frames) -> list[Track]:
        assert self._forces is not None
        low = float(self._ground.position[2])
        below = tops_under(self._around, solid.com, solid.time, low) + _ABOVE_GROUND
        return [
            Track(("/com",), solid.com),
            Track(("/blot",), np.column_stack([solid.com[:, :2], below]), solid.yaw_wxyz),
            *self._forces.tracks(solid),
            *self._blocks.tracks(solid.time),
        ]

    def _nodes(self) -> Nodes:
        nodes: Nodes = {"/com": self._com, "/blot": self._blot, **self._blocks.nodes}
        for ellipsoid in (self._model, self._whole, self._rigid):
            nodes |= ellipsoid.nodes
        for robot in (self._solid, self._shade, *(nodes for _, nodes in self._ghosts)):
            nodes |= {} if robot is None else robot.nodes
        return nodes | ({} if self._forces is None else self._forces.nodes)

    def _ghost(self, ghost: Ghost) -> RobotNodes:
        self._ghosts_made += 1
        name = f"/pinned/{self._ghosts_made}"
        return RobotNodes(self._client, ghost.robot, name, ghost=ghost.colour)

    def _apply_layers(self) -> None:
        there, simulated = self._planned is not None, self._simulated is not None
        self._model.show(visible=there and self._show_ellipsoids)
        self._rigid.show(visible=there and not simulated and self._show_ellipsoids)
        self._whole.show(visible=simulated and self._show_ellipsoids)
        self._trails.show(visible=there and self._show_trails)
        if self._shade is not None:
            self._shade.show(visible=simulated and self._show_ghost)
        for _, nodes in self._ghosts:
            nodes.show(visible=self._show_ghost)
        if self._forces is not None:
            self._forces.show(visible=there and self._show_forces)

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


def _ellipsoid(ellipsoid: Ellipsoid, frames: Frames) -> Track:
    return ellipsoid.track(frames.com, frames.inertia_wxyz, frames.inertia_axes)
