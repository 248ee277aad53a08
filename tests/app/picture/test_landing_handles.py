import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.picture.landing_handles import LandingHandles
from llsrbm.request.jump import Jump
from llsrbm.request.route import Landing, waypoints
from llsrbm.robots import load_robot
from tests.app.picture.gizmo import Gizmo

ROBOT = load_robot("anymal")
TASK = ROBOT.file.task
JUMP = Jump(robot="anymal", model="srbm", twist=0.5, height=0.1)
ROUTE = Jump(
    robot="anymal",
    route=(
        Landing(forward=0.3, height=0.1, twist=math.pi / 2),
        Landing(forward=0.2, height=-0.1, slope=0.1),
        Landing(forward=0.3),
    ),
)


class Target:
    def __init__(self):
        self.grips, self.gizmos, self.painted = [], [], []
        scene = SimpleNamespace(add_transform_controls=self._add)
        client = SimpleNamespace(scene=scene)
        self.handles = LandingHandles(client, self.grips.append, self.painted.append)

    def _add(self, name, **options):
        self.gizmos.append(Gizmo(name=name, **options))
        self.gizmos[-1].place(0.0, 0.0, 0.0)
        return self.gizmos[-1]

    @property
    def gizmo(self):
        return self.gizmos[0]

    def draw(self, jump, robot=ROBOT, *, visible=True):
        return self.handles.draw(jump, robot, visible=visible)

    def read(self, jump, task, landing=0):
        """The request after a handle was dragged to where it stands."""
        dragged = self.drag(landing=landing)
        return jump if dragged is None else dragged.applied_to(jump, task)

    def drag(self, phase="update", landing=0):
        """The session takes what the handle says."""
        self.gizmos[landing].drag(phase)
        return self.handles.read(self.grips[-1])


def test_it_stands_where_the_jump_lands():
    target = Target()
    target.draw(replace(JUMP, forward=0.3, lateral=-0.1))
    assert target.gizmo.position == pytest.approx((0.3, -0.1, 0.1))
    assert target.gizmo.wxyz == pytest.approx((math.cos(0.25), 0, 0, math.sin(0.25)))


def test_every_landing_of_a_route_has_its_own():
    target = Target()
    assert target.draw(ROUTE)
    assert not target.draw(ROUTE)
    assert target.painted == ["/goal", "/goal1", "/goal2"]
    first, second, third = target.gizmos
    assert first.position == pytest.approx((0.3, 0.0, 0.1))
    assert second.position == pytest.approx((0.3, 0.2, 0.0))  # it had turned to the left
    assert third.position == pytest.approx((0.3, 0.5, 0.0))
    assert third.wxyz == pytest.approx((math.cos(math.pi / 4), 0, 0, math.sin(math.pi / 4)))
    assert first.scale == second.scale == third.scale
    target.draw(JUMP)
    assert [gizmo.visible for gizmo in target.gizmos] == [True, False, False]


def test_of_a_route_one_landing_is_dragged_and_the_others_stay():
    target = Target()
    target.draw(ROUTE)
    target.gizmos[1].place(0.2512, 0.3, math.radians(60))
    moved = target.read(ROUTE, TASK, landing=1)
    target.draw(moved)
    assert [tuple(place) for place in waypoints(moved.route)] == [
        pytest.approx((0.3, 0.0, 0.1, math.pi / 2)),
        pytest.approx((0.25, 0.3, 0.0, math.pi / 3)),
        pytest.approx((0.3, 0.5, 0.0, math.pi / 2)),
    ]
    assert [landing.slope for landing in moved.route] == [0.0, 0.1, 0.0]


def test_no_landing_is_dragged_out_of_the_world():
    target = Target()
    target.draw(ROUTE)
    target.gizmos[2].place(9.0, 0.0, 0.0)
    assert target.read(ROUTE, TASK, landing=2) == ROUTE
    target.gizmos[2].place(0.0, 0.3, 0.0)
    plain = replace(JUMP, twist=0.0, forward=0.1)
    assert target.read(plain, TASK, landing=2) == replace(plain, forward=0.0, lateral=0.3)


def test_where_it_was_dragged_to_is_asked_for_in_the_sliders_steps():
    target = Target()
    target.gizmo.place(0.3149, -0.1051, math.radians(30.4))
    expected = replace(JUMP, forward=0.31, lateral=-0.11, twist=math.radians(30))
    assert target.read(JUMP, TASK) == expected


@pytest.mark.parametrize("broken", [(math.nan, 0, 0), (0, math.inf, 0), (0, 0, math.nan)])
def test_what_is_no_place_changes_nothing(broken):
    target = Target()
    target.gizmo.place(*broken)
    assert target.read(JUMP, TASK) == JUMP


@pytest.mark.parametrize("nonsense", ["here", None, [], [1.0, 0.0], [[0.0] * 4], [None] * 4, {}])
@pytest.mark.parametrize("field", ["position", "wxyz"])
def test_what_is_no_pose_changes_nothing(field, nonsense):
    target = Target()
    setattr(target.gizmo, field, nonsense)
    assert target.read(JUMP, TASK) == JUMP


def test_it_turns_on_beyond_half_a_turn():
    """The attitude is the same as that of the angle less a whole turn; the nearer one counts."""
    target, wide = Target(), TASK.model_copy(update={"twist": (-7.0, 7.0)})
    jump = replace(JUMP, twist=math.radians(170))
    for degrees in range(175, 350, 5):
        target.gizmo.place(0.0, 0.0, math.radians(degrees))
        jump = target.read(jump, wide)
        assert math.degrees(jump.twist) == pytest.approx(degrees)


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(-20, 20), st.floats(-3.1, 3.1))
def test_whatever_is_dragged_is_within_the_ranges(x, y, yaw, twist):
    target = Target()
    target.gizmo.place(x, y, yaw)
    read = target.read(replace(JUMP, twist=twist), TASK)
    for name in ("forward", "lateral", "twist"):
        lowest, highest = getattr(TASK, name)
        assert lowest - 0.01 <= getattr(read, name) <= highest + 0.01
    assert (read.robot, read.model, read.height) == (JUMP.robot, JUMP.model, JUMP.height)


def test_it_stays_in_the_hand_that_holds_it():
    target = Target()
    target.gizmo.place(0.2, 0.1, 0.0)
    target.drag("start")
    target.draw(replace(JUMP, forward=0.2))
    assert target.gizmo.position == pytest.approx((0.2, 0.1, 0.0))
    target.drag("end")
    target.draw(replace(JUMP, forward=0.2))
    assert target.gizmo.position == pytest.approx((0.2, 0.0, 0.1))
    assert len(target.grips) == 2


def test_it_is_shown_where_there_is_a_target():
    target = Target()
    for jump, robot, visible in (
        (None, ROBOT, True),
        (JUMP, None, True),
        (JUMP, ROBOT, False),
    ):
        target.draw(jump, robot, visible=visible)
        assert not target.gizmo.visible
    target.draw(JUMP)
    assert target.gizmo.visible


@pytest.mark.parametrize("name", ["anymal", "slider"])
def test_its_arrows_reach_out_from_under_the_robot(name):
    target, robot = Target(), load_robot(name)
    target.draw(JUMP, robot)
    width = np.ptp(robot.feet[:, :2], axis=0).max()
    assert width / 2 < target.gizmo.scale < 1.5 * width
