"""An arrow on the trunk with a ball at its tip, to be dragged (static/parts.js): a push, drawn.

The page draws what hangs below "/push" over everything else (static/player.js): it begins inside
of the robot.
"""

import math
from dataclasses import dataclass

import numpy as np
import viser

from app.motion import colours

Vector = tuple[float, float, float]

_BALL = 0.03  # m, radius
_SHAFT, _HEAD, _HEAD_LENGTH = 0.012, 0.03, 0.07  # m, of the arrow
_NO_LENGTH = 0.01  # m; a shorter arrow is not drawn
_TO_BEGIN = "drag to push"


@dataclass(frozen=True)
class PushShown:
    """The push at one instant."""

    time: float  # s, the instant that is shown
    origin: Vector  # m, world frame, of the trunk's CoM then
    impulse: Vector  # N s, world frame; zeros: none begins at that instant
    metres_per_newton_second: float  # the arrow's scale

    @property
    def tip(self) -> Vector:
        """Tip of the arrow, m."""
        tip = np.add(self.origin, np.multiply(self.impulse, self.metres_per_newton_second))
        return float(tip[0]), float(tip[1]), float(tip[2])


class PushHandle:
    """The arrow, the ball at its tip and its size in words."""

    def __init__(self, client: viser.ClientHandle) -> None:
        """Hidden."""
        self._shown: PushShown | None = None
        scene = client.scene
        self._ball = scene.add_icosphere(
            "/push/tip",
            _BALL,
            colours.FORCE,
            subdivisions=2,
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
        )
        self._arrow = scene.add_arrows(
            "/push/arrow",
            np.zeros((1, 2, 3)),
            colours.FORCE,
            shaft_radius=_SHAFT,
            head_radius=_HEAD,
            head_length=_HEAD_LENGTH,
            visible=False,
        )
        self._size = scene.add_label("/push/size", "", anchor="bottom-center", visible=False)

    def draw(self, shown: PushShown | None) -> bool:
        """Show a push, or nothing; whether anything new is drawn."""
        if shown == self._shown:
            return False
        self._shown = shown
        self._ball.visible = self._size.visible = shown is not None
        if shown is None:
            self._arrow.visible = False
            return False
        self._ball.position = self._size.position = shown.tip
        self._arrow.visible = math.dist(shown.tip, shown.origin) > _NO_LENGTH
        self._arrow.points = np.array([[shown.origin, shown.tip]], dtype=np.float32)
        there = any(shown.impulse)
        self._size.text = newton_seconds(shown.impulse) if there else _TO_BEGIN
        # Below the ball, the words leave the arrow free that a moment ago was drawn of a push.
        self._size.anchor = "bottom-center" if there else "top-center"
        return True


def newton_seconds(impulse: Vector) -> str:
    """An impulse's size in words."""
    return f"{math.hypot(*impulse):.3g} N s"
