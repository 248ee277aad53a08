"""Robots' links as nodes of a scene, solid or as ghosts; the robot itself, and its soft shadow.

Meshes are by far the largest that a tab is sent, so none is sent to it twice: a robot that is not
shown any more is hidden, and found again when it is shown next.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import chain, count

import numpy as np
import viser

from app.motion.clip import AnimationChannel, CameraTarget, Track
from app.motion.colours import Rgb
from app.picture import gltf
from app.picture.blocks import tops_under
from app.picture.bounds import around, around_default, around_landings, corners, outermost
from app.picture.drawing import Drawing
from app.picture.parts import Part, parts_of
from app.picture.picture import Picture
from llsrbm.look.collision_visuals import collision_visuals
from llsrbm.look.shown_motion import ShownMotion
from llsrbm.look.visuals import LinkVisual, default_pose, link_visuals, needs_preparation
from llsrbm.motion.block import Block
from llsrbm.robots import Robot

KEPT = 4  # Hidden robots that a tab keeps, the ones shown last: some MB of memory each in a browser

_GHOST_OPACITY = 0.25


@lru_cache(maxsize=16)
def meshes(
    robot: Robot, *, fine: bool = False, ghost: Rgb | None = None, stand_in: bool = False
) -> tuple[tuple[str, int, bytes], ...]:
    """(link, body, glTF) of each body, ghosts in one colour; `stand_in`: collision shapes."""

    def glb(visual: LinkVisual) -> bytes:
        if ghost is None:
            return visual.glb()
        return gltf.solid(visual.mesh(), ghost, _GHOST_OPACITY, both_sides=False)

    visuals = collision_visuals(robot) if stand_in else link_visuals(robot, coarse=not fine)
    return tuple((visual.link, visual.joint_id - 1, glb(visual)) for visual in visuals)


class RobotNodes:
    """One drawn robot, in its default posture until it is moved."""

    def __init__(
        self,
        scene: viser.SceneApi,  # a tab's
        robot: Robot,  # what to draw
        name: str,  # of the node above the links
        *,
        ghost: Rgb | None = None,  # translucent, in this colour
        # with all triangles. A browser without a graphics processor draws the coarse ones in half
        # the time, and every page opens sooner with them; ghosts never need more
        fine: bool = False,
    ) -> None:
        self.robot = robot  # that is drawn
        self._scene = scene
        self._name = name
        self._ghost = ghost
        self._fine = fine
        self._stand_in = needs_preparation(robot)
        self._frame = scene.add_frame(name, show_axes=False)
        self._twin: RobotNodes | None = None  # with all triangles, while it stands
        self._nodes: dict[str, viser.GlbHandle] = {}
        self._bodies: dict[str, int] = {}
        self._draw()
        self.base = next(iter(self._nodes), name)  # name of the node of its first body

    def refine(self) -> None:
        """Draw all triangles from now on."""
        if not self._fine:
            self._fine = True
            self._draw()

    def complete(self) -> None:
        """Draw meshes prepared by now in place of stand-ins; bodies may change."""
        if self._stand_in and not needs_preparation(self.robot):
            self._stand_in = False
            self._draw()

    def _draw(self) -> None:
        position, wxyz = default_pose(self.robot)
        bodies = meshes(
            self.robot,
            fine=self._fine and not self._stand_in,
            ghost=self._ghost,
            stand_in=self._stand_in,
        )
        before, self._bodies = self._nodes, {}
        self._nodes = {}
        for link, body, glb in bodies:
            node = f"{self._name}/{link}"
            self._bodies[node] = body
            handle = before.pop(node, None)
            if handle is not None:
                handle.glb_data = glb
            self._nodes[node] = handle or self._scene.add_glb(
                node,
                glb,
                position=position[body],
                wxyz=wxyz[body],
                # If a lamp casts any: where there is a graphics processor.
                cast_shadow=self._ghost is None,
                receive_shadow=self._ghost is None,
            )
        for handle in before.values():
            handle.remove()

    def track(self, frames: ShownMotion) -> list[Track]:
        """Every body's way through a motion of this robot."""
        return [
            Track(self._moved(name), frames.body_position[:, body], frames.body_wxyz[:, body])
            for name, body in self._bodies.items()
        ]

    def _moved(self, node: str) -> tuple[str, ...]:
        """A node and its twin, which may come later than the motion."""
        if self._fine or self._ghost is not None:
            return (node,)
        return node, node.replace(self._name, self._twins, 1)

    @property
    def _twins(self) -> str:
        return f"{self._name}-still"

    @property
    def bodies(self) -> Mapping[str, int]:
        """Nodes that draw a body, and its index."""
        return self._bodies

    def still(self) -> AnimationChannel:
        """Every body where it is in the default posture."""
        position, wxyz = default_pose(self.robot)
        return AnimationChannel(
            np.zeros(1),
            tuple(
                Track(self._moved(name), position[body, None], wxyz[body, None])
                for name, body in self._bodies.items()
            ),
        )

    def show(self, *, visible: bool) -> None:
        """Show or hide."""
        self._frame.visible = visible
        if self._twin is not None:
            self._twin.show(visible=False)

    def stand(self, *, still: bool) -> bool:
        """Show it with all triangles, or again without; whether nodes were made for that."""
        still = still and not (self._fine or self._stand_in)
        made = still and self._twin is None
        if made:
            self._twin = RobotNodes(self._scene, self.robot, self._twins, fine=True)
        self.show(visible=not still)
        if self._twin is not None:
            self._twin.show(visible=still)
        return made

    def remove(self) -> None:
        """Remove for good."""
        self._frame.remove()
        if self._twin is not None:
            self._twin.remove()


class RobotShelf:
    """The robots of one kind that a tab has been sent: solid ones, or ghosts."""

    def __init__(self, scene: viser.SceneApi, names: Iterator[str]) -> None:
        self._scene = scene
        self._names = names
        # In the order in which they were taken last.
        self._made: dict[tuple[Robot, Rgb | None], RobotNodes] = {}

    def take(self, robot: Robot, *, ghost: Rgb | None = None, fine: bool = False) -> RobotNodes:
        """The nodes of a robot: those of before, with meshes prepared meanwhile, or new ones."""
        key = (robot, ghost)
        nodes = self._made.pop(key, None)
        if nodes is None:
            nodes = RobotNodes(self._scene, robot, next(self._names), ghost=ghost, fine=fine)
        else:
            nodes.complete()
            if fine:
                nodes.refine()
        self._made[key] = nodes
        return nodes

    def show_only(self, shown: Collection[RobotNodes]) -> None:
        """Show these and hide all others; of the others, remove those that were taken long ago."""
        hidden = []
        for key, nodes in self._made.items():
            visible = nodes in shown
            nodes.show(visible=visible)
            if not visible:
                hidden.append(key)
        for key in hidden[: max(0, len(hidden) - KEPT)]:
            self._made.pop(key).remove()


_ASIDE, _AHEAD = (0.12, -1.0, 0.16), (1.0, -0.12, 0.16)  # directions that a camera looks from
_EVERY = 4  # frames between those that a camera has in sight
_ABOVE_GROUND = 0.002  # m; a shadow would flicker in the ground's own plane
_LONG, _WIDE = 0.75, 0.62  # length and width of the shadow, in the robot's
_SPREADS = 0.5  # a shadow is larger by that share of its height above the ground, per m


class SolidRobot(Drawing):
    """Simulated, or planned, or in its default posture."""

    parts = frozenset({"robot", "planned", "simulated", "blocks", "fine", "prepared"})
    needs_motion = False

    def __init__(self, scene: viser.SceneApi) -> None:
        super().__init__(scene)
        names = chain(["/links"], (f"/links-{number}" for number in count(2)))
        self._shelf = RobotShelf(scene, names)
        self._nodes: RobotNodes | None = None
        # what a camera looks at; None: there is no robot
        self.camera_target: CameraTarget | None = None
        self.robot_parts: tuple[Part, ...] = ()  # that can be pointed at

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        robot, frames = picture.robot, picture.solid
        if robot is None:
            self._nodes = self.camera_target = None
            self.robot_parts = ()
            self._shelf.show_only(())
            return ()
        nodes = self._nodes = self._shelf.take(robot, fine=picture.fine)
        self._shelf.show_only((nodes,))
        self.robot_parts = parts_of(robot, nodes.bodies)
        if frames is None:
            points = around_landings(robot, picture.target)
            self.camera_target = CameraTarget(nodes.base, outermost(points))
            return [nodes.still()]
        swept = around(robot, frames.body_position[::_EVERY], frames.body_wxyz[::_EVERY])
        points = np.concatenate([swept.reshape(-1, 3), *map(corners, picture.blocks)])
        direction = _seen_from(picture)
        self.camera_target = CameraTarget(nodes.base, outermost(points), direction=direction)
        return [AnimationChannel(frames.time, tuple(nodes.track(frames)))]

    def show(self, *, visible: bool) -> None:
        """The robot is always seen."""

    def stand(self, *, still: bool) -> bool:
        """As `RobotNodes.stand`."""
        return self._nodes is not None and self._nodes.stand(still=still)


def _seen_from(picture: Picture) -> tuple[float, float, float] | None:
    """The direction from which a whole turn is seen best; None: all jumps else are seen askew."""
    jump = None if picture.planned is None else picture.planned.plan.jump
    if jump is None or not jump.turns:
        return None
    return _ASIDE if jump.pitch else _AHEAD


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
        track = shadow_track(self._disc.name, robot, frames, picture.blocks, picture.ground)
        return [AnimationChannel(frames.time, (track,))]

    def show(self, *, visible: bool) -> None:
        if self._disc is not None:
            self._disc.visible = visible


def shadow_track(
    name: str, robot: Robot, frames: ShownMotion, blocks: Sequence[Block], ground: float
) -> Track:
    """A disc's way below a robot: larger the higher it is above what is there."""
    below = tops_under(blocks, frames.com, frames.time, ground)
    across = np.ptp(around_default(robot)[..., :2], axis=(0, 1, 2)) * [_LONG, _WIDE]
    larger = 1 + _SPREADS * np.maximum(frames.com[:, 2] - below - robot.com[2], 0.0)
    size = np.column_stack([larger * across[0], larger * across[1], np.ones(len(larger))])
    position = np.column_stack([frames.com[:, :2], below + _ABOVE_GROUND])
    return Track((name,), position, frames.yaw_wxyz, size)
