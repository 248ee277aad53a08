"""Clicks on the ground, while the picture asks for them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import viser

from app.guard.validation import numbers

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class GroundClicked:
    """The picture was clicked: a line of sight, from a point and along a direction, world frame."""

    origin: Vector  # m
    direction: Vector

    def meets(self, height: float) -> tuple[float, float] | None:
        """Where it meets the level at a height (m): x, y; None: it looks away from it."""
        (x, y, z), (dx, dy, dz) = self.origin, self.direction
        if dz * (height - z) <= 0:
            return None
        share = (height - z) / dz
        return x + share * dx, y + share * dy


class GroundClicks:
    """Has viser report clicks or not; a drag is none, and goes on to move the camera."""

    def __init__(self, client: viser.ClientHandle, put: Callable[[GroundClicked], None]) -> None:
        """Without; `put` is called on viser's event loop and must return at once."""
        self._scene, self._put, self._wanted = client.scene, put, False

    def draw(self, *, wanted: bool) -> None:
        """Have them from now on, or no more."""
        if wanted == self._wanted:
            return
        self._wanted = wanted
        if wanted:
            self._scene.on_click()(self._clicked)  # type: ignore[arg-type]  # viser awaits it
        else:
            self._scene.remove_click_callback(self._clicked)

    async def _clicked(self, event: viser.SceneClickEvent) -> None:
        # A script may send anything for a ray.
        origin, direction = numbers(event.ray_origin, 3), numbers(event.ray_direction, 3)
        if origin is not None and direction is not None:
            (x, y, z), (dx, dy, dz) = origin, direction
            self._put(GroundClicked((x, y, z), (dx, dy, dz)))
