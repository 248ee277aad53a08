"""Where the feet shall land, and the step up or down."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import viser
from scipy.spatial.transform import Rotation

from app.motion import colours
from app.motion.clip import Strand
from app.scene.blocks import attitude
from app.scene.drawing import Overlay
from app.scene.picture import Picture
from llsrbm.motion.plan import Plan
from llsrbm.robots import Robot

_FOOTPRINT = 0.03  # m, radius of a point foot's mark
_SOLE_EDGE = 0.01  # m, of a sole's mark around the contact points
_THIN = 0.004  # m, thickness of a mark


class LandingMarks(Overlay):
    """A disc for a point foot, and a sole's outline turned as the sole shall be, at every landing.

    A step is a translucent block, as long as no simulation has blocks of its own. The landing
    handle, which is drawn by `app.scene.landing_handle`, is shown and hidden with the marks.
    """

    name = "landing"
    title = "Landing handle"
    hint = "Where the feet shall land; drag the arrows, or the ring, to move the landing."
    at_first = True
    parts = frozenset({"robot", "planned", "simulated", "blocks"})

    def __init__(self, scene: viser.SceneApi) -> None:
        """See `Drawing`."""
        super().__init__(scene)
        self._robot: Robot | None = None
        self._marks: list[viser.CylinderHandle | viser.BoxHandle] = []
        self._landings = 0  # feet that land, each as often as it does
        self._step: viser.BoxHandle | None = None
        self._stepping = False

    def draw(self, picture: Picture) -> Sequence[Strand]:
        """See `Drawing.draw`."""
        robot, planned = picture.robot, picture.planned
        assert robot is not None
        assert planned is not None
        if robot is not self._robot:
            self._forget(robot)
        plan = planned.plan
        height, landings = plan.jump.height, _landings(plan)
        self._landings = len(landings)
        while len(self._marks) < len(landings):
            self._marks.append(self._add_mark(robot, f"/target/foot{len(self._marks)}"))
        corners = robot.corners
        centre = (corners.min(axis=0) + corners.max(axis=0)) / 2 * [1.0, 1.0, 0.0]
        for mark, (knot, foot) in zip(self._marks, landings, strict=False):
            position, wxyz = plan.foot_position[knot, foot], plan.foot_quat[knot, foot]
            x, y, z = position + Rotation.from_quat(wxyz, scalar_first=True).apply(centre)
            mark.position = (x, y, z + 0.003)
            mark.wxyz = wxyz
        steps = picture.blocks if picture.simulated is None else ()
        self._stepping = len(steps) > 0
        for step in steps:
            assert self._step is not None
            self._step.dimensions = (float(step.size[0]), float(step.size[1]), float(step.size[2]))
            self._step.position = step.centre
            self._step.wxyz = attitude(step)
            # A step down is the block the robot starts from.
            self._step.color = colours.TARGET if height > 0 else colours.FOOT
        self.show(visible=True)
        return ()

    def show(self, *, visible: bool) -> None:
        """See `Drawing.show`."""
        for index, mark in enumerate(self._marks):
            mark.visible = visible and index < self._landings
        if self._step is not None:
            self._step.visible = visible and self._stepping

    def _forget(self, robot: Robot) -> None:
        """No marks yet, as this robot's feet may be others."""
        for mark in self._marks:
            mark.remove()
        self._marks = []
        self._robot = robot
        if self._step is None:
            self._step = self.scene.add_box(
                "/target/step",
                colours.TARGET,
                opacity=0.22,
                cast_shadow=False,
                receive_shadow=False,
            )

    def _add_mark(self, robot: Robot, name: str) -> viser.CylinderHandle | viser.BoxHandle:
        if robot.file.foot.is_point:
            return self.scene.add_cylinder(
                name,
                _FOOTPRINT,
                _THIN,
                colours.TARGET,
                radial_segments=16,
                cast_shadow=False,
                receive_shadow=False,
            )
        length, width = np.ptp(robot.corners, axis=0)[:2] + 2 * _SOLE_EDGE
        return self.scene.add_box(
            name,
            colours.TARGET,
            dimensions=(float(length), float(width), _THIN),
            cast_shadow=False,
            receive_shadow=False,
        )


def _landings(plan: Plan) -> list[tuple[int, int]]:
    """Knot and foot of each landing: the last knot at which the foot stands in a place."""
    place = np.array([phase.place for phase in plan.schedule])[plan.phase]
    landings = []
    for number in range(1, plan.schedule.places + 1):
        stands = plan.contact & (place == number)[:, None]
        landings += [
            (int(np.flatnonzero(there)[-1]), foot)
            for foot, there in enumerate(stands.T)
            if there.any()
        ]
    return landings
