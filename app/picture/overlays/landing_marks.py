"""Where the feet shall land, and the step up or down."""

from collections.abc import Sequence

import numpy as np
import viser
from scipy.spatial.transform import Rotation

from app.motion import colours
from app.motion.clip import AnimationChannel
from app.picture.blocks import place
from app.picture.drawing import Group, Overlay
from app.picture.picture import Picture
from llsrbm.motion.plan import Plan
from llsrbm.robots import Robot

_FOOTPRINT = 0.03  # m, radius of a point foot's mark
_SOLE_EDGE = 0.01  # m, of a sole's mark around the contact points
_THIN = 0.004  # m, thickness of a mark
# By what a block is called: the one that the robot starts from, and what it passes over; on all
# others it lands.
_COLOURS = {"block": colours.REFERENCE, "hurdle": colours.BLOCK}


class LandingMarks(Overlay):
    """A disc for a point foot, and a sole's outline turned as the sole shall be, at every landing.

    Steps and hurdles are translucent blocks, as long as no simulation has blocks of its own. The
    landing handle and those of single feet (`app.picture.landing_handles`, `foothold_handles`) are
    shown and hidden with the marks.
    """

    name = "landing"
    root = "/target"
    group = Group.FOOTHOLDS
    title = "Landing handle"
    hint = (
        "Target footholds; drag arrows or ring to move the landing, a foot's square for it alone."
    )
    place = 60
    tints = (colours.TARGET,)
    at_first = True
    common = True
    parts = frozenset({"robot", "planned", "simulated", "blocks"})

    def __init__(self, scene: viser.SceneApi) -> None:
        super().__init__(scene)
        self._robot: Robot | None = None
        self._marks: list[viser.CylinderHandle | viser.BoxHandle] = []
        self._landings = 0  # feet that land, each as often as it does
        self._steps: list[viser.BoxHandle] = []
        self._stepping = 0  # of them, those that are drawn

    def draw(self, picture: Picture) -> Sequence[AnimationChannel]:
        robot, planned, _ = picture.motion
        if robot is not self._robot:
            self._forget(robot)
        plan = planned.plan
        landings = _landings(plan)
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
        blocks = picture.blocks if picture.simulated is None else ()
        self._stepping = len(blocks)
        while len(self._steps) < len(blocks):
            self._steps.append(self._add_step(f"/target/step{len(self._steps)}"))
        for step, block in zip(self._steps, blocks, strict=False):
            place(step, block)
            step.color = _COLOURS.get(block.name, colours.TARGET)
        return ()

    def show(self, *, visible: bool) -> None:
        for index, mark in enumerate(self._marks):
            mark.visible = visible and index < self._landings
        for index, step in enumerate(self._steps):
            step.visible = visible and index < self._stepping

    def _forget(self, robot: Robot) -> None:
        for mark in self._marks:
            mark.remove()
        self._marks = []
        self._robot = robot

    def _add_step(self, name: str) -> viser.BoxHandle:
        return self.scene.add_box(
            name,
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
