"""What is drawn besides the robot, one class each; nodes are made once and then only changed.

Making a node costs a browser far more than moving it: new buffers, perhaps a new shader.
"""

from __future__ import annotations

import numpy as np
import viser
from numpy.typing import NDArray

from app.replay import Replay
from llsrbm.trajectory.plan import Phase

Array = NDArray[np.float64]
Rgb = tuple[int, int, int]

PLANNED_COLOUR: Rgb = (44, 123, 229)
RIGID_COLOUR: Rgb = (240, 140, 30)
FORCE_COLOUR: Rgb = (214, 51, 108)
COM_COLOUR: Rgb = (90, 60, 180)
FOOT_COLOUR: Rgb = (110, 120, 130)
TARGET_COLOUR: Rgb = (40, 160, 90)
INFEASIBLE_COLOUR: Rgb = (220, 40, 40)

ARROW_PER_WEIGHT = 0.8
"""Length of the arrow of a force as large as the robot's weight, m."""

_OUTSIDE = 1.004  # a wireframe must lie just outside of a surface to be seen
_FOOTPRINT = 0.03  # m, radius of a landing mark
_MARGIN = 0.12  # m, of the landing surface around the feet
_ALONG_TRAIL = 4  # frames between the points of a trail
_PUSHING = 1.0  # N; smaller forces are not drawn


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
    """An arrow a contact, from the contact along the force."""

    def __init__(self, client: viser.ClientHandle, contacts: int) -> None:
        """Hidden."""
        self._arrows = client.scene.add_arrows(
            "/arrows",
            np.zeros((contacts, 2, 3), dtype=np.float32),
            FORCE_COLOUR,
            shaft_radius=0.008,
            head_radius=0.02,
            head_length=0.04,
            visible=False,
        )
        self._interval = -1

    def move(self, replay: Replay, frame: int) -> None:
        """Show a frame's forces, if they differ: they are constant over an interval."""
        interval = int(replay.interval[frame])
        if interval == self._interval:
            return
        self._interval = interval
        force = replay.motion.contact_force[frame]
        pushing = bool(np.abs(force).max() > _PUSHING)
        if pushing:
            foot = replay.motion.contact_point[frame]
            tip = foot + force * (ARROW_PER_WEIGHT / replay.weight)
            self._arrows.points = np.stack([foot, tip], axis=1).astype(np.float32)
        self._arrows.visible = pushing

    def hide(self) -> None:
        """Hide until the next `move`."""
        self._arrows.visible = False
        self._interval = -1

    def remove(self) -> None:
        """Remove for good."""
        self._arrows.remove()


class Trails:
    """The paths of the CoM and, in flight, of the feet."""

    def __init__(self, client: viser.ClientHandle) -> None:
        """Hidden."""
        nothing = np.zeros((1, 2, 3), dtype=np.float32)
        add = client.scene.add_line_segments
        self._com = add("/path/com", nothing, COM_COLOUR, thickness=0.008, visible=False)
        self._feet = add("/path/feet", nothing, FOOT_COLOUR, thickness=0.005, visible=False)

    def draw(self, replay: Replay) -> None:
        """Take a motion's paths."""
        motion = replay.motion
        last = len(motion.time) - 1
        kept = np.append(np.arange(0, last, _ALONG_TRAIL), last)
        flight = np.flatnonzero(motion.phase == Phase.FLIGHT)[::_ALONG_TRAIL]
        self._com.points = _segments(motion.com[kept, None])
        self._feet.points = _segments(motion.foot_position[flight])
        colour = COM_COLOUR if replay.plan.solved else INFEASIBLE_COLOUR
        # One colour for all, as when the node was made.
        self._com.colors = np.array(colour, dtype=np.uint8)

    def show(self, *, visible: bool) -> None:
        """Show or hide."""
        self._com.visible = self._feet.visible = visible


class Target:
    """Marks where the feet shall land, and the step up or down as a translucent block."""

    def __init__(self, client: viser.ClientHandle, feet: int) -> None:
        """Hidden."""
        scene = client.scene
        self._marks = [
            scene.add_cylinder(
                f"/target/foot{i}",
                _FOOTPRINT,
                0.004,
                TARGET_COLOUR,
                radial_segments=16,
                cast_shadow=False,
                visible=False,
            )
            for i in range(feet)
        ]
        self._step = scene.add_box(
            "/target/step", TARGET_COLOUR, opacity=0.22, cast_shadow=False, visible=False
        )

    def draw(self, replay: Replay) -> None:
        """Take a plan's."""
        plan = replay.plan
        height, landing = plan.jump.height, plan.foot_position[-1]
        for mark, foot in zip(self._marks, landing, strict=True):
            mark.position = (foot[0], foot[1], height + 0.003)
            mark.visible = True
        self._step.visible = height != 0
        if height == 0:
            return
        # A step down is drawn as the block the robot starts from.
        feet = landing if height > 0 else plan.foot_position[0]
        low, high = feet[:, :2].min(axis=0) - _MARGIN, feet[:, :2].max(axis=0) + _MARGIN
        self._step.dimensions = (high[0] - low[0], high[1] - low[1], abs(height))
        self._step.position = (*((low + high) / 2), height / 2)
        self._step.color = TARGET_COLOUR if height > 0 else FOOT_COLOUR

    def remove(self) -> None:
        """Remove for good."""
        for node in (*self._marks, self._step):
            node.remove()


def _segments(points: Array) -> NDArray[np.float32]:
    """Paths (K, n, 3) as their pieces, (n (K - 1), 2, 3)."""
    pieces = np.stack([points[:-1], points[1:]], axis=2)
    return pieces.reshape(-1, 2, 3).astype(np.float32)
