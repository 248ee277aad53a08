"""A handle on the ground where the robot shall land: to be dragged and turned in the picture."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import viser

from llsrbm.jump import Jump
from llsrbm.robots import Robot
from llsrbm.robots.schema import Task

_REACH = 1.3  # length of the arrows, in the feet's distance from their middle
_LINE = 3.0  # pixels


class TargetHandle:
    """Arrows along x and y, and a ring to turn it; follows the sliders unless it is held."""

    def __init__(self, client: viser.ClientHandle, moved: Callable[[], None]) -> None:
        """Hidden.

        Args:
            client: whose scene.
            moved: called from viser's thread when it was dragged, must return at once.
        """
        self._jump: Jump | None = None
        self._held = False
        self._handle = client.scene.add_transform_controls(
            "/goal",
            line_width=_LINE,
            active_axes=(True, True, False),
            opacity=0.7,
            visible=False,
        )

        @self._handle.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            self._held = event.phase != "end"
            moved()

    def read(self, jump: Jump, task: Task) -> Jump:
        """The request with the landing place where the handle stands, within the robot's ranges.

        Args:
            jump: the request as it is; height, robot and model stay.
            task: the robot's ranges.
        """
        wxyz, position = _numbers(self._handle.wxyz, 4), _numbers(self._handle.position, 3)
        if wxyz is None or position is None:
            return jump
        (w, _, _, z), (x, y, _) = wxyz, position
        # The handle turns on beyond half a turn; of the angles that look alike, the nearest one.
        turned = 2 * math.atan2(z, w) - jump.twist
        twist = jump.twist + math.remainder(turned, 2 * math.pi)
        return replace(
            jump,
            twist=_whole_degrees(_within(twist, task.twist)),
            forward=_whole_centimetres(_within(x, task.forward)),
            lateral=_whole_centimetres(_within(y, task.lateral)),
        )

    def show(self, jump: Jump) -> None:
        """Stand where a jump shall land, unless it is being dragged."""
        if self._held or jump == self._jump:
            return
        self._jump = jump
        half = jump.twist / 2
        self._handle.position = (jump.forward, jump.lateral, jump.height)
        self._handle.wxyz = (math.cos(half), 0.0, 0.0, math.sin(half))

    def show_robot(self, robot: Robot) -> None:
        """Reach out from under this robot."""
        across = robot.feet[:, :2] - robot.feet[:, :2].mean(axis=0)
        self._handle.scale = float(_REACH * np.linalg.norm(across, axis=1).max())

    def set_visible(self, visible: bool) -> None:
        """Show or hide."""
        self._handle.visible = visible


def _numbers(values: object, count: int) -> tuple[float, ...] | None:
    """So many finite numbers, or None: a script may send anything for a pose."""
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        return None
    if array.shape != (count,) or not np.isfinite(array).all():
        return None
    return tuple(float(value) for value in array)


def _within(value: float, ends: tuple[float, float]) -> float:
    return min(max(value, ends[0]), ends[1])


def _whole_degrees(angle: float) -> float:
    return math.radians(round(math.degrees(angle)))


def _whole_centimetres(length: float) -> float:
    return round(length, 2)
