"""What is drawn besides the robot, one class each; nodes are made once and then only changed.

Making a node costs a browser far more than moving it: new buffers, perhaps a new shader.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import viser
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from app import colours
from app.colours import Rgb
from app.frames import Frames
from llsrbm.robots import Robot
from llsrbm.simulation.surroundings import Block
from llsrbm.trajectory.plan import Plan

Array = NDArray[np.float64]

ARROW_PER_WEIGHT = 0.8
"""Length of the arrow of a force as large as the robot's weight, m."""

_OUTSIDE = 1.004  # a wireframe must lie just outside of a surface to be seen
_FOOTPRINT = 0.03  # m, radius of a point foot's landing mark
_SOLE_EDGE = 0.01  # m, of a sole's landing mark around the contact points
_THIN = 0.004  # m, thickness of a landing mark
_ALONG_TRAIL = 4  # frames between the points of a trail
_PUSHING = 1.0  # N; smaller forces are not drawn
_STILL = 1e-5  # m; arrows that move less are not sent again
_NOTHING = np.zeros((1, 2, 3), dtype=np.float32)  # a line without a length
_OUT_OF_SIGHT = np.array([0.0, 0.0, -100.0])  # m; an arrow without length would still have a head


class Ellipsoid:
    """A unit sphere, a wireframe with or without a translucent surface, moved and stretched."""

    def __init__(
        self, client: viser.ClientHandle, name: str, colour: Rgb, *, surface: bool
    ) -> None:
        """Hidden."""
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
        """Put its centre at `position` (3,) m, its semi-axes `axes` (3,) m along `wxyz` (4,)."""
        self._frame.position = position
        self._frame.wxyz = wxyz
        if not np.allclose(axes, self._axes, atol=1e-4):
            self._axes = axes
            for sphere in self._spheres:
                sphere.scale = (float(axes[0]), float(axes[1]), float(axes[2]))

    def show(self, *, visible: bool) -> None:
        """Show or hide."""
        self._frame.visible = visible


class Forces:
    """An arrow a foot, from where the force acts along the force."""

    def __init__(self, client: viser.ClientHandle, feet: int) -> None:
        """Hidden."""
        self._points = np.zeros((feet, 2, 3), dtype=np.float32)
        self._visible = False
        self._arrows = client.scene.add_arrows(
            "/arrows",
            self._points,
            colours.FORCE,
            shaft_radius=0.008,
            head_radius=0.02,
            head_length=0.04,
            visible=False,
        )

    def move(self, frames: Frames, frame: int) -> None:
        """Show a frame's forces, if they differ: planned ones are constant over an interval."""
        force, foot = frames.foot_force[frame], frames.pressed_at[frame]
        pushing = np.linalg.norm(force, axis=1) > _PUSHING
        if pushing.any():
            tip = foot + force * (ARROW_PER_WEIGHT / frames.weight)
            points = np.stack([foot, tip], axis=1)
            points[~pushing] = _OUT_OF_SIGHT
            self._put(points.astype(np.float32))
        self._show(visible=bool(pushing.any()))

    def hide(self) -> None:
        """Hide until the next `move`."""
        self._show(visible=False)

    def remove(self) -> None:
        """Remove for good."""
        self._arrows.remove()

    def _put(self, points: NDArray[np.float32]) -> None:
        if points.shape != self._points.shape or np.abs(points - self._points).max() > _STILL:
            self._points = points
            self._arrows.points = points

    def _show(self, *, visible: bool) -> None:
        if visible != self._visible:
            self._visible = visible
            self._arrows.visible = visible


class Trails:
    """The paths of the CoM and, in flight, of the feet."""

    def __init__(self, client: viser.ClientHandle) -> None:
        """Hidden."""
        add = client.scene.add_line_segments
        self._com = add("/path/com", _NOTHING, colours.COM, thickness=0.008, visible=False)
        self._feet = add("/path/feet", _NOTHING, colours.FOOT, thickness=0.005, visible=False)

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
        self._nodes: list[tuple[Block, viser.BoxHandle]] = []

    def draw(self, blocks: Sequence[Block]) -> None:
        """Replace all by these; hidden until `move`."""
        for _, node in self._nodes:
            node.remove()
        self._nodes = [
            (
                block,
                self._client.scene.add_box(
                    f"/blocks/{index}",
                    colours.BLOCK,
                    dimensions=tuple(block.size),
                    position=block.centre,
                    wxyz=_turned(block),
                    opacity=0.55,
                    cast_shadow=False,
                    visible=False,
                ),
            )
            for index, block in enumerate(blocks)
        ]

    def move(self, time: float) -> None:
        """Show those that stand there at `time`, s."""
        for block, node in self._nodes:
            there = block.from_s <= time < block.until_s
            if node.visible != there:
                node.visible = there


def top_under(blocks: Sequence[Block], point: Array, time: float, ground: float) -> float:
    """Height of what lies below a point (3,) m at `time`, s: the ground's, or a block's top, m."""
    tops = [ground]
    for block in blocks:
        c, s = math.cos(block.yaw), math.sin(block.yaw)
        x, y = (point - block.centre)[:2]
        beside = np.abs([c * x + s * y, c * y - s * x]) > block.size[:2] / 2
        if block.from_s <= time < block.until_s and not beside.any():
            tops.append(float(block.centre[2] + block.size[2] / 2))
    return max(tops)


def _turned(block: Block) -> tuple[float, float, float, float]:
    """A block's attitude, w, x, y, z."""
    return math.cos(block.yaw / 2), 0.0, 0.0, math.sin(block.yaw / 2)


def _segments(points: Array) -> NDArray[np.float32]:
    """Paths (K, n, 3) as their pieces, (n (K - 1), 2, 3)."""
    pieces = np.stack([points[:-1], points[1:]], axis=2)
    return pieces.reshape(-1, 2, 3).astype(np.float32)
