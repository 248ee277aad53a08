"""An arrow on the trunk whose tip is dragged in the picture: a push, drawn.

The page draws what hangs below "/push" over everything else (static/player.js): it begins inside
of the robot.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import viser

from app.guard.validation import vector
from app.motion import colours

Vector = tuple[float, float, float]

_SIZE = 0.3  # m, of the grip's own arrows
_LINE = 3.0  # pixels
_SHAFT, _HEAD, _HEAD_LENGTH = 0.012, 0.03, 0.07  # m, of the arrow
_NO_LENGTH = 0.01  # m; a shorter arrow is not drawn
_TO_BEGIN = "drag to push"


@dataclass(frozen=True)
class PushDragged:
    """Where the arrow's tip was dragged to."""

    time: float  # s, the instant that was shown
    impulse: Vector  # N s, world frame
    ended: bool  # whether it was let go of


@dataclass(frozen=True)
class PushShown:
    """The push at one instant."""

    time: float  # s, the instant that is shown
    origin: Vector  # m, world frame, of the trunk's CoM then
    impulse: Vector  # N s, world frame; zeros: none begins at that instant
    metres_per_newton_second: float  # the arrow's scale

    @property
    def tip(self) -> Vector:
        """Of the arrow, m."""
        tip = np.add(self.origin, np.multiply(self.impulse, self.metres_per_newton_second))
        return float(tip[0]), float(tip[1]), float(tip[2])

    def impulse_to(self, tip: Vector) -> Vector:
        """The impulse whose arrow ends there, N s; its vertical part stays."""
        x, y = (
            (a - b) / self.metres_per_newton_second
            for a, b in zip(tip[:2], self.origin[:2], strict=True)
        )
        return x, y, self.impulse[2]


class PushHandle:
    """The arrow, the grip at its tip and its size in words; stays where it is held."""

    def __init__(self, client: viser.ClientHandle, moved: Callable[[PushDragged], None]) -> None:
        """Hidden; `moved` is called from viser's thread and must return at once."""
        self._shown: PushShown | None = None
        self._held: PushShown | None = None
        scene = client.scene
        self._grip = scene.add_transform_controls(
            "/push/tip",
            _SIZE,
            line_width=_LINE,
            active_axes=(True, True, False),
            disable_rotations=True,
            depth_test=False,
            opacity=0.8,
            visible=False,
        )
        self._arrow = scene.add_arrows(
            "/push/arrow",
            np.zeros((1, 2, 3)),
            colours.PUSH,
            shaft_radius=_SHAFT,
            head_radius=_HEAD,
            head_length=_HEAD_LENGTH,
            visible=False,
        )
        self._size = scene.add_label("/push/size", "", anchor="bottom-center", visible=False)

        @self._grip.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            shown = self._held or self._shown
            tip = vector(self._grip.position)
            if shown is None:
                return
            ended = event.phase == "end"
            self._held = None if ended else shown
            if ended:
                self._shown = None  # the next drawing puts it where the push ends
            if tip is not None:
                moved(PushDragged(shown.time, shown.impulse_to(tip), ended))

    def draw(self, shown: PushShown | None) -> bool:
        """Show a push, or nothing, but for a grip that is held; whether anything new is drawn."""
        if shown == self._shown:
            return False
        self._shown = shown
        visible = shown is not None
        self._grip.visible = self._size.visible = visible
        if shown is None:
            self._arrow.visible = False
            self._held = None
            return False
        if self._held is None:
            self._grip.position = shown.tip
        length = math.dist(shown.tip, shown.origin)
        self._arrow.visible = length > _NO_LENGTH
        self._arrow.points = np.array([[shown.origin, shown.tip]], dtype=np.float32)
        self._size.position = shown.tip
        there = any(shown.impulse)
        self._size.text = newton_seconds(shown.impulse) if there else _TO_BEGIN
        # Below the grip, the words leave the arrow free that a moment ago was drawn of a push.
        self._size.anchor = "bottom-center" if there else "top-center"
        return True


def newton_seconds(impulse: Vector) -> str:
    """An impulse's size in words."""
    return f"{math.hypot(*impulse):.3g} N s"
