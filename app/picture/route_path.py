"""A route on the ground: a line from landing to landing, and their numbers."""

from collections.abc import Sequence

import numpy as np
import viser

from app.motion import colours
from app.motion.clip import AnimationChannel
from app.picture.drawing import Drawing
from app.picture.overlays.landing_marks import LandingMarks
from app.picture.picture import Picture
from llsrbm.request.route import START, waypoints

_ABOVE = 0.01  # m, of the line over what the robot lands on
_THICK = 3.0  # pixels


class RoutePath(Drawing):
    """Drawn of the request, which a plan follows later; with the landing marks."""

    parts = frozenset({"target", "layers"})
    needs_motion = False

    def __init__(self, scene: viser.SceneApi) -> None:
        super().__init__(scene)
        self._line: viser.LineSegmentsHandle | None = None
        self._numbers: list[viser.LabelHandle] = []
        self._landings = 0

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        shown = picture.target is not None and LandingMarks.name in picture.layers
        route = picture.target.route if shown and picture.target is not None else ()
        self._landings = len(route)
        self.show(visible=True)
        if not route:
            return ()
        places = waypoints(route)
        ends = np.array([place[:3] for place in (START, *places)])
        ends[:, 2] += _ABOVE
        points = np.stack([ends[:-1], ends[1:]], axis=1).astype(np.float32)
        if self._line is None:
            self._line = self.scene.add_line_segments(
                "/route/line", points, colours.TARGET, thickness=_THICK, thickness_units="screen"
            )
        self._line.points = points
        while len(self._numbers) < len(places):
            number = str(len(self._numbers) + 1)
            self._numbers.append(
                self.scene.add_label(f"/route/{number}", number, anchor="bottom-center")
            )
        for label, (x, y, z) in zip(self._numbers, ends[1:].tolist(), strict=False):
            label.position = (x, y, z)
        return ()

    def show(self, *, visible: bool) -> None:
        if self._line is not None:
            self._line.visible = visible and self._landings > 0
        for number, label in enumerate(self._numbers):
            label.visible = visible and number < self._landings
