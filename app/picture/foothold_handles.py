"""Handles on the ground under the feet of the robot that lands: one foot each, to be dragged."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import viser

from app.guard.validation import numbers
from llsrbm.errors import InputError
from llsrbm.mechanics import turns_about_z
from llsrbm.planning.problem.placement import place_task
from llsrbm.planning.problem.stones import within_reach
from llsrbm.planning.problem.task import Footholds
from llsrbm.request.jump import Jump
from llsrbm.request.stones import Stone
from llsrbm.robots import Robot

_SIDE = 0.22  # length of a handle's square, in the feet's distance from their middle
_SHORTEST = 0.05  # m of it: feet of humanoids are near each other
# Of drei's PivotControls: the side of a square, and where its centre is along both axes.
_SQUARE, _CENTRE = 0.225, 1.7 / 7
_ABOVE = 0.006  # m above what the foot lands on, over its mark


@dataclass(frozen=True)
class FootholdMoved:
    """A foot's handle was moved, or let go of; it is read as it stands when this is taken."""

    foot: int
    held: bool
    begins: bool = False  # whether it was gripped just now


@dataclass(frozen=True)
class FootholdDragged:
    """Where a foot's handle was dragged to: m beside where the foot lands by itself."""

    leg: str
    dx: float  # ahead, as the robot looks that lands
    dy: float  # to the left
    grip: int = 1  # number of the grip that it is dragged with, one after another
    held: bool = True

    def applied_to(self, jump: Jump, robot: Robot) -> Jump:
        """A request whose foot lands there, or as far on the way as the leg reaches."""
        height = next((stone.dz for stone in jump.stones if stone.leg == self.leg), 0.0)
        return within_reach(jump, Stone(self.leg, self.dx, self.dy, height), robot)


class FootholdHandles:
    """A square under each foot; it stands where the foot shall land unless it is held."""

    root = "/footholds"  # of their names in the scene

    def __init__(
        self,
        client: viser.ClientHandle,
        put: Callable[[FootholdMoved], None],
        paint: Callable[[str], None],
    ) -> None:
        """Without handles; `put` is called on viser's event loop and must return at once.

        `paint`: called with the name of each that is added.
        """
        self._scene, self._put, self._paint = client.scene, put, paint
        self._handles: list[viser.TransformControlsHandle] = []
        self._robot: Robot | None = None
        self._drawn: Jump | None = None
        self._place: Footholds | None = None
        self._held: int | None = None
        self._grips = 0

    def read(self, moved: FootholdMoved) -> FootholdDragged | None:
        """Where one stands; None if a script has put it nowhere."""
        self._held = moved.foot if moved.held else None
        self._grips += moved.begins
        # Wherever it was let go: the next drawing puts it where the target is.
        self._drawn = None
        robot, place = self._robot, self._place
        if robot is None or place is None or moved.foot >= len(robot.legs):
            return None
        at = numbers(self._handles[moved.foot].position, 3)
        if at is None:
            return None
        turned = turns_about_z(place.heading)
        dx, dy, _ = turned.T @ (at - place.origin) + self._corner - robot.feet[moved.foot]
        leg = robot.leg_names[moved.foot]
        return FootholdDragged(leg, float(dx), float(dy), self._grips, moved.held)

    def draw(self, target: Jump | None, robot: Robot | None, *, visible: bool) -> bool:
        """Stand where the feet shall land, but for the one that is held; nothing known: hidden.

        Returns whether some have just appeared: a page makes them anew then.
        """
        shown = 0
        if visible and target is not None and robot is not None:
            self._put_at(target, robot)
            shown = 0 if self._drawn is None else len(robot.legs)
        appear = any(not handle.visible for handle in self._handles[:shown])
        for foot, handle in enumerate(self._handles):
            handle.visible = foot < shown
        return appear

    def _put_at(self, target: Jump, robot: Robot) -> None:
        if (target, robot) == (self._drawn, self._robot):
            return
        try:
            place = place_task(target, robot).places[-1]
        except InputError:  # of another robot, or of a type's file that is not there any more
            self._drawn = None
            return
        while len(self._handles) < len(robot.legs):
            self._add()
        if robot is not self._robot:
            self._robot = robot
            for handle in self._handles:
                handle.scale = self._scale
        self._drawn, self._place = target, place
        half = place.heading / 2
        corners = place.feet - turns_about_z(place.heading) @ self._corner
        for foot, (handle, at) in enumerate(zip(self._handles, corners, strict=False)):
            if foot != self._held:
                x, y, z = map(float, at)
                handle.position = (x, y, z)
                handle.wxyz = (math.cos(half), 0.0, 0.0, math.sin(half))

    @property
    def _scale(self) -> float:
        assert self._robot is not None
        across = self._robot.feet[:, :2] - self._robot.feet[:, :2].mean(axis=0)
        side = _SIDE * float(np.linalg.norm(across, axis=1).max())
        return max(side, _SHORTEST) / _SQUARE

    @property
    def _corner(self) -> Any:
        """(3,) m: from a handle's origin to the middle of its square, but for what it is above."""
        along = _CENTRE * self._scale
        return np.array([along, along, -_ABOVE])

    def _add(self) -> None:
        foot = len(self._handles)
        name = f"{self.root}/{foot}"
        handle = self._scene.add_transform_controls(
            name,
            active_axes=(True, True, False),
            disable_axes=True,
            disable_rotations=True,
            opacity=0.7,
            visible=False,
        )

        @handle.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            self._put(FootholdMoved(foot, event.phase != "end", event.phase == "start"))

        self._handles.append(handle)
        self._paint(name)
