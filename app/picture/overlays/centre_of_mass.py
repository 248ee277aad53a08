"""The centre of mass of the robot that is drawn solid, and the paths of it and of the feet."""

from collections.abc import Sequence

import numpy as np
import viser
from numpy.typing import NDArray

from app.motion import colours
from app.motion.clip import AnimationChannel, Track
from app.picture.drawing import Group, Overlay
from app.picture.picture import Picture
from llsrbm.arrays import Array, stretches

_RADIUS = 0.018  # m


class CentreOfMass(Overlay):
    """A ball."""

    name = "com"
    root = "/com"
    group = Group.INERTIA
    title = "Centre of mass"
    hint = "Centre of mass of the whole robot, from the model or the simulation."
    place = 20
    tints = (colours.COM,)
    at_first = True

    _ball: viser.IcosphereHandle | None = None

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        _, _, frames = picture.motion
        if self._ball is None:
            self._ball = self.scene.add_icosphere(
                "/com",
                _RADIUS,
                colours.COM,
                subdivisions=1,
                cast_shadow=False,
                receive_shadow=False,
            )
        return [AnimationChannel(frames.time, (Track((self._ball.name,), frames.com),))]

    def show(self, *, visible: bool) -> None:
        if self._ball is not None:
            self._ball.visible = visible


_ALONG = 2  # frames between the points of a trail
_NOTHING = np.zeros((1, 2, 3), dtype=np.float32)  # a line without a length


class Trails(Overlay):
    """Lines that do not move; those of a plan that breaks constraints have a warning colour."""

    name = "trails"
    root = "/path"
    group = Group.INERTIA
    title = "Trails"
    hint = "The paths of the centre of mass and, in flight, of the feet."
    place = 40
    tints = (
        colours.COM,
        colours.FOOT,
    )
    at_first = True
    common = True

    _lines: tuple[viser.LineSegmentsHandle, viser.LineSegmentsHandle] | None = None

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        _, planned, frames = picture.motion
        if self._lines is None:
            self._lines = self._add("com", colours.COM, 3.0), self._add("feet", colours.FOOT, 2.0)
        com, feet = self._lines
        last = len(frames.time) - 1
        kept = np.append(np.arange(0, last, _ALONG), last)
        com.points = _segments(frames.com[kept, None])
        feet.points = np.concatenate(
            [_NOTHING]  # a robot that fell early may never have flown
            + [
                _segments(frames.foot_position[start:end:_ALONG, foot, None])
                for foot in range(frames.stands.shape[1])
                for start, end in stretches(~frames.stands[:, foot])
            ]
        )
        # One colour for all, as when the node was made.
        colour = colours.COM if planned.plan.solved else colours.INFEASIBLE
        com.colors = np.array(colour, dtype=np.uint8)
        return ()

    def show(self, *, visible: bool) -> None:
        for line in self._lines or ():
            line.visible = visible

    def _add(
        self, name: str, colour: tuple[int, int, int], thickness: float
    ) -> viser.LineSegmentsHandle:
        return self.scene.add_line_segments(
            f"/path/{name}", _NOTHING, colour, thickness=thickness, thickness_units="screen"
        )


def _segments(points: Array) -> NDArray[np.float32]:
    """Paths (K, n, 3) as their pieces, (n (K - 1), 2, 3)."""
    pieces = np.stack([points[:-1], points[1:]], axis=2)
    return pieces.reshape(-1, 2, 3).astype(np.float32)
