"""What is drawn besides the robot, one class each; nodes are made once and then only changed.

Making a node costs a browser far more than moving it: new buffers, perhaps a new shader.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from app.motion import colours
from app.motion.clip import Track
from app.motion.colours import Rgb, linear
from app.motion.frames import Frames
from llsrbm.motion.plan import Plan
from llsrbm.robots import Robot
from llsrbm.simulation.surroundings import Block

Array = NDArray[np.float64]
Nodes = dict[str, Any]
"""Name -> viser's handle of what moves with a clip."""

ARROW_PER_WEIGHT = 0.8
"""Length of the arrow of a force as large as the robot's weight, m."""

_OUTSIDE = 1.004  # a wireframe must lie just outside of a surface to be seen
_FOOTPRINT = 0.03  # m, radius of a point foot's landing mark
_SOLE_EDGE = 0.01  # m, of a sole's landing mark around the contact points
_THIN = 0.004  # m, thickness of a landing mark
_ALONG_TRAIL = 2  # frames between the points of a trail
_PUSHING = 1.0  # N; smaller forces are not drawn
_NOTHING = np.zeros((1, 2, 3), dtype=np.float32)  # a line without a length
_SUBDIVISIONS = 2  # of an icosahedron: 320 triangles


class Ellipsoid:
    """A unit sphere, a wireframe with or without a translucent surface, turned and stretched."""

    def __init__(
        self, client: viser.ClientHandle, name: str, colour: Rgb, *, surface: bool
    ) -> None:
        """Hidden."""
        scene = client.scene
        self._frame = scene.add_frame(name, show_axes=False, visible=False)
        self.nodes: Nodes = {
            f"{name}/wires": scene.add_icosphere(
                f"{name}/wires",
                _OUTSIDE,
                colour,
                subdivisions=_SUBDIVISIONS,
                wireframe=True,
                opacity=0.35,
                cast_shadow=False,
            )
        }
        if surface:
            self.nodes[f"{name}/surface"] = scene.add_icosphere(
                f"{name}/surface",
                1.0,
                colour,
                subdivisions=_SUBDIVISIONS,
                opacity=0.22,
                cast_shadow=False,
            )

    def track(self, position: Array, wxyz: Array, axes: Array) -> Track:
        """Its centre at `position` (F, 3) m, its semi-axes `axes` (F, 3) m along `wxyz` (F, 4)."""
        return Track(tuple(self.nodes), position, wxyz, axes)

    def show(self, *, visible: bool) -> None:
        """Show or hide."""
        self._frame.visible = visible


class Forces:
    """An arrow a foot, from where the force acts along the force."""

    def __init__(self, client: viser.ClientHandle, feet: int) -> None:
        """Hidden."""
        scene = client.scene
        self._frame = scene.add_frame("/arrows", show_axes=False, visible=False)
        self.nodes: Nodes = {
            name: scene.add_glb(name, _arrow(), cast_shadow=False, receive_shadow=False)
            for name in (f"/arrows/{foot}" for foot in range(feet))
        }

    def tracks(self, frames: Frames) -> list[Track]:
        """Every foot's force over a motion; none where a foot hardly pushes."""
        length = np.linalg.norm(frames.foot_force, axis=2)
        pushing = length > _PUSHING
        along = np.where(pushing[..., None], frames.foot_force, [0.0, 0.0, 1.0])
        long = np.where(pushing, length * ARROW_PER_WEIGHT / frames.weight, 0.0)
        wide = pushing.astype(float)
        return [
            Track(
                (name,),
                frames.pressed_at[:, foot],
                _turned_up_to(along[:, foot]),
                np.stack([wide[:, foot], wide[:, foot], long[:, foot]], axis=1),
            )
            for foot, name in enumerate(self.nodes)
        ]

    def show(self, *, visible: bool) -> None:
        """Show or hide."""
        self._frame.visible = visible

    def remove(self) -> None:
        """Remove for good."""
        self._frame.remove()


class Trails:
    """The paths of the CoM and, in flight, of the feet."""

    def __init__(self, client: viser.ClientHandle) -> None:
        """Hidden."""
        add = client.scene.add_line_segments
        self._com = add(
            "/path/com",
            _NOTHING,
            colours.COM,
            thickness=3.0,
            thickness_units="screen",
            visible=False,
        )
        self._feet = add(
            "/path/feet",
            _NOTHING,
            colours.FOOT,
            thickness=2.0,
            thickness_units="screen",
            visible=False,
        )

    def draw(self, frames: Frames, *, feasible: bool) -> None:
        """Take a motion's paths; one that breaks constraints gets a warning colour."""
        last = len(frames.time) - 1
        kept = np.append(np.arange(0, last, _ALONG_TRAIL), last)
        flight = np.flatnonzero(frames.flight)[::_ALONG_TRAIL]
        self._com.points = _segments(frames.com[kept, None])
        # A robot that fell early may never have flown.
        self._feet.points = _segments(frames.foot_position[flight]) if len(flight) > 1 else _NOTHING
        # One colour for all, as when the node was made.
        colour = colours.COM if feasible else colours.INFEASIBLE
        self._com.colors = np.array(colour, dtype=np.uint8)

    def show(self, *, visible: bool) -> None:
        """Show or hide."""
        self._com.visible = self._feet.visible = visible


class Target:
    """Marks where the feet shall land, and the step up or down as a translucent block.

    A mark is a disc for a point foot, and a sole's outline turned as the sole shall be.
    """

    def __init__(self, client: viser.ClientHandle, robot: Robot) -> None:
        """Hidden."""
        self._client = client
        corners = robot.corners
        self._sole = None if robot.file.foot.is_point else np.ptp(corners, axis=0)[:2]
        self._centre = (corners.min(axis=0) + corners.max(axis=0)) / 2 * [1.0, 1.0, 0.0]
        scene = client.scene
        self._marks = [self._add_mark(f"/target/foot{i}") for i in range(len(robot.legs))]
        self._step = scene.add_box(
            "/target/step", colours.TARGET, opacity=0.22, cast_shadow=False, visible=False
        )

    def draw(self, plan: Plan, steps: Sequence[Block]) -> None:
        """Take a plan's marks, and the step if there is one among `steps`."""
        height, landing = plan.jump.height, plan.foot_position[-1]
        for mark, foot, wxyz in zip(self._marks, landing, plan.foot_quat[-1], strict=True):
            x, y, _ = foot + Rotation.from_quat(wxyz, scalar_first=True).apply(self._centre)
            mark.position = (x, y, height + 0.003)
            mark.wxyz = wxyz
            mark.visible = True
        self._step.visible = len(steps) > 0
        for step in steps:
            self._step.dimensions = tuple(step.size)
            self._step.position = step.centre
            self._step.wxyz = _turned(step)
            # A step down is the block the robot starts from.
            self._step.color = colours.TARGET if height > 0 else colours.FOOT

    def remove(self) -> None:
        """Remove for good."""
        for node in (*self._marks, self._step):
            node.remove()

    def _add_mark(self, name: str) -> viser.CylinderHandle | viser.BoxHandle:
        if self._sole is None:
            return self._client.scene.add_cylinder(
                name,
                _FOOTPRINT,
                _THIN,
                colours.TARGET,
                radial_segments=16,
                cast_shadow=False,
                visible=False,
            )
        length, width = self._sole + 2 * _SOLE_EDGE
        return self._client.scene.add_box(
            name,
            colours.TARGET,
            dimensions=(length, width, _THIN),
            cast_shadow=False,
            visible=False,
        )


class Blocks:
    """What the simulated robot stands and lands on besides the ground, while it is there."""

    def __init__(self, client: viser.ClientHandle) -> None:
        """Nothing is there."""
        self._client = client
        self._blocks: Sequence[Block] = ()
        self.nodes: Nodes = {}

    def draw(self, blocks: Sequence[Block]) -> None:
        """Replace all by these."""
        for node in self.nodes.values():
            node.remove()
        self._blocks = blocks
        self.nodes = {
            name: self._client.scene.add_box(
                name,
                colours.BLOCK,
                dimensions=tuple(block.size),
                position=block.centre,
                wxyz=_turned(block),
                opacity=0.55,
                cast_shadow=False,
            )
            for name, block in ((f"/blocks/{i}", block) for i, block in enumerate(blocks))
        }

    def tracks(self, time: Array) -> list[Track]:
        """Each block at its place at those of the instants (F,) s at which it stands there."""
        return [
            Track(
                (name,),
                np.broadcast_to(block.centre, (len(time), 3)),
                scale=np.repeat(_stands(block, time)[:, None], 3, axis=1).astype(float),
            )
            for name, block in zip(self.nodes, self._blocks, strict=True)
        ]


def tops_under(blocks: Sequence[Block], points: Array, time: Array, ground: float) -> Array:
    """(F,) m: heights of what lies below points (F, 3) m: the ground's, or a block's top.

    Args:
        blocks: what stands around.
        points: (F, 3) m, at the instants `time` (F,) s.
        time: s.
        ground: m.
    """
    tops = np.full(len(points), ground)
    for block in blocks:
        c, s = math.cos(block.yaw), math.sin(block.yaw)
        x, y = (points - block.centre)[:, :2].T
        above = np.abs(np.stack([c * x + s * y, c * y - s * x], axis=1)) <= block.size[:2] / 2
        there = _stands(block, time) & above.all(axis=1)
        top = float(block.centre[2] + block.size[2] / 2)
        tops = np.where(there, np.maximum(tops, top), tops)
    return tops


def _stands(block: Block, time: Array) -> NDArray[np.bool_]:
    return (block.from_s <= time) & (time < block.until_s)


def _turned_up_to(along: Array) -> Array:
    """Quaternions (F, 4) that turn z to the directions `along` (F, 3), the short way."""
    z = along / np.linalg.norm(along, axis=1, keepdims=True)
    wxyz = np.stack([1 + z[:, 2], -z[:, 1], z[:, 0], np.zeros(len(z))], axis=1)
    # Straight down, any half turn about a horizontal axis.
    wxyz[z[:, 2] < -1 + 1e-9] = [0.0, 1.0, 0.0, 0.0]
    turned: Array = wxyz / np.linalg.norm(wxyz, axis=1, keepdims=True)
    return turned


@lru_cache(maxsize=1)
def _arrow() -> bytes:
    """An arrow along z, 1 m long, as glTF; stretched by its node's scale."""
    import trimesh
    from trimesh.visual.material import PBRMaterial

    head, shaft = 0.2, 0.008  # share of the length; m, radius
    body = trimesh.creation.cylinder(shaft, 1 - head, sections=8)
    body.apply_translation([0.0, 0.0, (1 - head) / 2])
    tip = trimesh.creation.cone(2.5 * shaft, head, sections=10)
    tip.apply_translation([0.0, 0.0, 1 - head])
    mesh = trimesh.util.concatenate([body, tip])
    colour = [*(linear(colours.FORCE)), 1.0]
    mesh.visual = trimesh.visual.TextureVisuals(
        material=PBRMaterial(baseColorFactor=colour, metallicFactor=0.0, roughnessFactor=0.8)
    )
    glb: bytes = mesh.export(file_type="glb")
    return glb


def _turned(block: Block) -> tuple[float, float, float, float]:
    """A block's attitude, w, x, y, z."""
    return math.cos(block.yaw / 2), 0.0, 0.0, math.sin(block.yaw / 2)


def _segments(points: Array) -> NDArray[np.float32]:
    """Paths (K, n, 3) as their pieces, (n (K - 1), 2, 3)."""
    pieces = np.stack([points[:-1], points[1:]], axis=2)
    return pieces.reshape(-1, 2, 3).astype(np.float32)
