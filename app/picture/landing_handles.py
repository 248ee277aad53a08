"""Handles on the ground where the robot shall land: to be dragged and turned in the picture."""

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
import viser

from app.guard.validation import numbers
from llsrbm.errors import InputError
from llsrbm.request.jump import Jump
from llsrbm.request.route import Waypoint, through, waypoints
from llsrbm.robots import Robot
from llsrbm.robots.schema import Task

_REACH = 1.3  # length of the arrows, in the feet's distance from their middle
_LINE = 3.0  # pixels


@dataclass(frozen=True)
class HandleMoved:
    """A landing's handle was moved, or let go of; it is read as it stands when this is taken."""

    landing: int
    held: bool
    begins: bool = False  # whether it was gripped just now


@dataclass(frozen=True)
class LandingDragged:
    """Where a landing's handle was dragged to."""

    x: float  # x, y: m, world frame
    y: float
    yaw: float  # rad; the same up to whole turns
    landing: int = 0
    grip: int = 1  # number of the grip that it is dragged with, one after another
    held: bool = True

    def applied_to(self, jump: Jump, task: Task) -> Jump:
        """A request that lands where the handle stands, height stays: a plain jump within the
        robot's ranges, and of a route one landing, while the others stay.
        """
        if jump.route:
            return self._on_route(jump)
        return replace(
            jump,
            twist=self._turned(jump.twist, task.twist),
            forward=_whole_centimetres(_within(self.x, task.forward)),
            lateral=_whole_centimetres(_within(self.y, task.lateral)),
        )

    def _on_route(self, jump: Jump) -> Jump:
        places = list(waypoints(jump.route))
        if self.landing >= len(places):
            return jump
        before = places[self.landing]
        places[self.landing] = Waypoint(
            _whole_centimetres(self.x),
            _whole_centimetres(self.y),
            before.z,
            self._turned(before.heading),
        )
        with suppress(InputError):  # farther than may be asked for
            return replace(jump, route=through(places, jump.route))
        return jump

    def _turned(self, before: float, ends: tuple[float, float] = (-math.inf, math.inf)) -> float:
        """Whole degrees; of angles that look alike the nearest, as it turns on past half a turn."""
        turn = before + math.remainder(self.yaw - before, 2 * math.pi)
        return math.radians(round(math.degrees(_within(turn, ends))))


class LandingHandles:
    """Arrows along x and y and a ring for each landing; one stands there unless it is held."""

    def __init__(
        self,
        client: viser.ClientHandle,
        put: Callable[[HandleMoved], None],
        paint: Callable[[str], None],
    ) -> None:
        """Hidden; `put` is called on viser's event loop and must return at once.

        `paint`: called with the name of each that is added.
        """
        self._scene, self._put, self._paint = client.scene, put, paint
        self._handles: list[viser.TransformControlsHandle] = []
        self._target: Jump | None = None
        self._robot: Robot | None = None
        self._held: int | None = None
        self._grips = 0
        self._add()

    def read(self, moved: HandleMoved) -> LandingDragged | None:
        """Where one stands; None if a script has put it nowhere."""
        self._held = moved.landing if moved.held else None
        self._grips += moved.begins
        # Wherever it was let go: the next drawing puts it where the target is.
        self._target = None
        handle = self._handles[moved.landing]
        found = read_pose(handle.wxyz, handle.position)
        return found and replace(found, landing=moved.landing, grip=self._grips, held=moved.held)

    def draw(self, target: Jump | None, robot: Robot | None, *, visible: bool) -> bool:
        """Stand where a jump shall land, but for the one that is dragged; none known: hidden.

        Returns whether some have just appeared: a page makes them anew then.
        """
        places: tuple[Waypoint, ...] = ()
        if visible and target is not None and robot is not None:
            places = waypoints(target.route or target.landings[:1])
            self._put_at(target, robot, places)
        appear = any(not handle.visible for handle in self._handles[: len(places)])
        for number, handle in enumerate(self._handles):
            handle.visible = number < len(places)
        return appear

    def _put_at(self, target: Jump, robot: Robot, places: tuple[Waypoint, ...]) -> None:
        while len(self._handles) < len(places):
            self._add()
            self._target = self._robot = None
        if robot is not self._robot:
            self._robot = robot
            across = robot.feet[:, :2] - robot.feet[:, :2].mean(axis=0)
            for handle in self._handles:
                handle.scale = float(_REACH * np.linalg.norm(across, axis=1).max())
        if target == self._target:
            return
        self._target = target
        for number, (handle, place) in enumerate(zip(self._handles, places, strict=False)):
            if number != self._held:
                half = place.heading / 2
                handle.position = (place.x, place.y, place.z)
                handle.wxyz = (math.cos(half), 0.0, 0.0, math.sin(half))

    def _add(self) -> None:
        landing = len(self._handles)
        name = f"/goal{landing or ''}"
        handle = self._scene.add_transform_controls(
            name,
            line_width=_LINE,
            active_axes=(True, True, False),
            opacity=0.7,
            visible=False,
        )

        @handle.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            self._put(HandleMoved(landing, event.phase != "end", event.phase == "start"))

        self._handles.append(handle)
        self._paint(name)


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
