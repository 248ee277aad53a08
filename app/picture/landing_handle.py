"""A handle on the ground where the robot shall land: to be dragged and turned in the picture."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import viser

from app.guard.validation import numbers
from llsrbm.request.jump import Jump
from llsrbm.robots import Robot
from llsrbm.robots.schema import Task

_REACH = 1.3  # length of the arrows, in the feet's distance from their middle
_LINE = 3.0  # pixels


@dataclass(frozen=True)
class HandleMoved:
    """The handle was moved, or let go of; it is read as it stands when this is taken."""

    held: bool


@dataclass(frozen=True)
class LandingDragged:
    """Where the handle was dragged to."""

    x: float  # x, y: m, world frame
    y: float
    yaw: float  # rad; the same up to whole turns

    def applied_to(self, jump: Jump, task: Task) -> Jump:
        """A request that lands where the handle stands, within the robot's ranges; height stays."""
        # The handle turns on beyond half a turn; of the angles that look alike, the nearest one.
        twist = jump.twist + math.remainder(self.yaw - jump.twist, 2 * math.pi)
        return replace(
            jump,
            twist=math.radians(round(math.degrees(_within(twist, task.twist)))),
            forward=_whole_centimetres(_within(self.x, task.forward)),
            lateral=_whole_centimetres(_within(self.y, task.lateral)),
        )


class LandingHandle:
    """Arrows along x and y, and a ring to turn it; stands at the target unless it is held."""

    node = "/goal"  # its name in the scene

    def __init__(self, client: viser.ClientHandle, put: Callable[[HandleMoved], None]) -> None:
        """Hidden; `put` is called on viser's event loop and must return at once."""
        self._target: Jump | None = None
        self._robot: Robot | None = None
        self._held = False
        self._handle = client.scene.add_transform_controls(
            self.node,
            line_width=_LINE,
            active_axes=(True, True, False),
            opacity=0.7,
            visible=False,
        )

        @self._handle.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            put(HandleMoved(event.phase != "end"))

    def read(self, moved: HandleMoved) -> LandingDragged | None:
        """Where it stands; None if a script has put it nowhere."""
        self._held = moved.held
        # Wherever it was let go: the next drawing puts it where the target is.
        self._target = None
        return read_pose(self._handle.wxyz, self._handle.position)

    def draw(self, target: Jump | None, robot: Robot | None, *, visible: bool) -> bool:
        """Stand where a jump shall land, unless it is being dragged; no jump or robot: hidden.

        Returns whether it has just appeared: a page makes it anew then.
        """
        shown = visible and target is not None and robot is not None
        appears = shown and not self._handle.visible
        self._handle.visible = shown
        if target is None or robot is None:
            return False
        if robot is not self._robot:
            self._robot = robot
            across = robot.feet[:, :2] - robot.feet[:, :2].mean(axis=0)
            self._handle.scale = float(_REACH * np.linalg.norm(across, axis=1).max())
        if self._held or target == self._target:
            return appears
        self._target = target
        half = target.twist / 2
        self._handle.position = (target.forward, target.lateral, target.height)
        self._handle.wxyz = (math.cos(half), 0.0, 0.0, math.sin(half))
        return appears


def read_pose(wxyz: object, position: object) -> LandingDragged | None:
    """Where a handle stands, or None: a script may send anything for a pose."""
    quaternion, place = numbers(wxyz, 4), numbers(position, 3)
    if quaternion is None or place is None:
        return None
    (w, _, _, z), (x, y, _) = quaternion, place
    return LandingDragged(x, y, 2 * math.atan2(z, w))


def _within(value: float, ends: tuple[float, float]) -> float:
    return min(max(value, ends[0]), ends[1])


def _whole_centimetres(length: float) -> float:
    return round(length, 2)
