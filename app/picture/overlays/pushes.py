"""An arrow on the trunk while it is pushed, with the push's size."""

from collections.abc import Sequence

import numpy as np
import viser

from app.motion import colours
from app.motion.baked import ARROW_PER_SPEED, FRAME_RATE, metres_per_newton_second, trunk_com
from app.motion.clip import AnimationChannel, Track
from app.motion.colours import Rgb
from app.picture import gltf
from app.picture.drawing import Group, Overlay
from app.picture.picture import Picture
from app.picture.push_handle import newton_seconds
from llsrbm.look.shown_motion import ShownMotion
from llsrbm.mechanics import turned_to

_SEEN = 0.1  # s for which a push is seen; it is over after a fifth of that
_WIDE = 1.6  # times as thick as the arrow of a force
_AWAY = (0.0, 0.0, 1000.0)  # m, where words are that nobody shall see: they have no size


class Pushes(Overlay):
    """Pushes of a simulation; the page draws them over everything else (static/player.js)."""

    name = "pushes"
    group = Group.FORCES
    title = "Pushes"
    hint = (
        "Pushes of a simulation, while they act; one that gives the robot 1 m/s is "
        f"{ARROW_PER_SPEED:g} m long."
    )
    place = 70
    at_first = True
    root = "/push/past"
    parts = frozenset({"robot", "planned", "simulated", "pushes"})

    @classmethod
    def swatch(cls, picture: Picture) -> Sequence[Rgb]:
        return [colours.FORCE] if picture.pushes else []

    def __init__(self, scene: viser.SceneApi) -> None:
        super().__init__(scene)
        self._words: list[viser.LabelHandle] = []

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        channels = super().draw(picture)
        return channels if picture.pushes else ()

    def tracks(self, picture: Picture, frames: ShownMotion) -> Sequence[Track]:
        pushes, (robot, _, _) = picture.pushes, picture.motion
        arrows = self.nodes(gltf.arrow(colours.FORCE), len(pushes), "arrow")
        while len(self._words) < len(pushes):
            self._words.append(
                self.scene.add_label(
                    f"{self.root}/words/{len(self._words)}", "", anchor="bottom-center"
                )
            )
        for index, label in enumerate(self._words):
            # The page has moved it; what it is put back to here would be no news to it.
            label.position, label.visible = _AWAY, index < len(pushes)
        origin = trunk_com(robot, frames)
        tracks = []
        for push, arrow, label in zip(pushes, arrows, self._words, strict=False):
            label.text = newton_seconds(push.impulse)
            reach = metres_per_newton_second(robot) * np.array(push.impulse)
            length = float(np.linalg.norm(reach))
            seen = (frames.time > push.time - 1 / FRAME_RATE) & (frames.time < push.time + _SEEN)
            seen &= length > 0  # a moment alone has no arrow
            size = np.array([_WIDE, _WIDE, length])
            tip = np.where(seen[:, None], origin + reach, _AWAY)
            along = np.broadcast_to(turned_to(reach, 2), (len(origin), 4))
            tracks += [
                Track((arrow,), origin, along, seen[:, None] * size),
                Track((label.name,), tip),
            ]
        return tracks
