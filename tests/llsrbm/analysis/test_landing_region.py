"""Where feet can still land: within the legs' reach, in the time that is left."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.analysis.landing_region import SIDES, Touchdown, expected_touchdown, landing_regions
from llsrbm.motion.replan import Replan, followed
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import FLY, STAND, synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout

ROBOT = load_robot("anymal")
REACH = ROBOT.file.reach
SPEED = 2.0  # m/s
LOWER = 0.05  # m, the trunk at touchdown than in the default posture: a tilted one reaches, too


@pytest.fixture(scope="module")
def plan():
    return synthetic_plan(Jump(twist=0.6, forward=0.1))


@pytest.fixture(scope="module")
def rollout(plan):
    return synthetic_rollout(plan)


def touchdown(yaw=0.0, tilt=0.0, ground=0.0):
    quat = Rotation.from_euler("zy", [yaw, tilt]).as_quat(scalar_first=True)
    return Touchdown(0.7, ROBOT.base_position - [0.0, 0.0, LOWER], quat, np.full(4, ground))


def area(points):
    x, y = points[:, 0], points[:, 1]
    return 0.5 * float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


@pytest.mark.parametrize(("yaw", "tilt"), [(1.0, 0.0), (-2.0, 0.15)])
@pytest.mark.parametrize("left", [0.01, 0.5])
def test_every_corner_is_reached_by_the_leg_in_time(yaw, tilt, left):
    expected = touchdown(yaw, tilt)
    turn = Rotation.from_quat(expected.base_quat, scalar_first=True)
    feet = expected.base_position + turn.apply(ROBOT.feet - ROBOT.base_position)
    outlines = landing_regions(ROBOT, REACH, SPEED, expected, feet, expected.time - left)
    for leg, outline in enumerate(outlines):
        assert outline is not None
        assert outline.shape == (SIDES, 3)
        assert outline[:, 2] == pytest.approx(np.zeros(SIDES))
        hip = expected.base_position + turn.apply(ROBOT.hips[leg])
        frame = outline + np.array([0, 0, ROBOT.foot_lift])
        local = turn.inv().apply(frame - hip) * ROBOT.mirrors[leg]
        assert (local >= np.array(REACH.lower) - 1e-9).all()
        assert (local <= np.array(REACH.upper) + 1e-9).all()
        assert (np.linalg.norm(local, axis=1) <= REACH.distance[1] + 1e-9).all()
        moved = np.linalg.norm((outline - feet[leg])[:, :2], axis=1)
        assert (moved <= SPEED * left + 1e-9).all()


def test_with_all_the_time_the_reach_alone_limits_it():
    """Against a fine grid of the ground, each point of which is reached or not."""
    expected = touchdown(0.4, 0.1)
    turn = Rotation.from_quat(expected.base_quat, scalar_first=True)
    feet = np.array(ROBOT.feet)
    outlines = landing_regions(ROBOT, REACH, SPEED, expected, feet, -10.0)
    side = np.linspace(-1, 1, 401)
    height = np.full((401, 401), ROBOT.foot_lift)  # of the feet's frames, standing
    ground = np.stack([*np.meshgrid(side, side), height], axis=-1).reshape(-1, 3)
    for leg, outline in enumerate(outlines):
        hip = expected.base_position + turn.apply(ROBOT.hips[leg])
        local = turn.inv().apply(ground - hip) * ROBOT.mirrors[leg]
        reached = ((local >= REACH.lower) & (local <= REACH.upper)).all(axis=1)
        reached &= np.linalg.norm(local, axis=1) <= REACH.distance[1]
        size = reached.sum() * (side[1] - side[0]) ** 2
        assert 0.9 * size < area(outline) <= 1.01 * size  # corners are cut


def test_a_foot_that_cannot_come_back_in_time_lands_nowhere():
    expected, feet = touchdown(), np.array(ROBOT.feet)
    feet[0] += [3.0, 0.0, 0.0]
    outlines = landing_regions(ROBOT, REACH, SPEED, expected, feet, 0.6)
    assert [outline is None for outline in outlines] == [True, False, False, False]


def test_in_flight_the_same_touchdown_is_expected_all_the_time(plan, rollout):
    """The CoM flies on a parabola: from each instant it ends in the same place."""
    found = [
        expected_touchdown(rollout, plan, ROBOT, time)
        for time in np.linspace(STAND + 0.02, STAND + FLY - 0.05, 5)
    ]
    assert {each.time for each in found} == {STAND + FLY}
    places = np.array([each.base_position for each in found])
    assert np.ptp(places, axis=0) == pytest.approx(np.zeros(3), abs=2e-3)
    knot = int(np.searchsorted(plan.time, STAND + FLY - 1e-9))
    assert found[0].base_quat == pytest.approx(plan.base_quat[knot])


def test_no_touchdown_is_expected_of_feet_that_stand(plan, rollout):
    for time in (0.0, STAND - 0.1, STAND + FLY + 0.05, plan.duration):
        assert expected_touchdown(rollout, plan, ROBOT, time) is None


def test_a_push_moves_the_touchdown_by_the_speed_that_it_gives(plan, rollout):
    speed = np.array([0.0, 0.5, 0.0])
    pushed = replace(rollout, linear_momentum=rollout.linear_momentum + ROBOT.mass * speed)
    time = STAND + 0.2
    before, after = (
        expected_touchdown(each, plan, ROBOT, time).base_position for each in (rollout, pushed)
    )
    assert after - before == pytest.approx(speed * (FLY - 0.2), abs=1e-6)


def replan(applied, touchdown=0.95, yaw=1.0):
    knots = np.array([0.5, 0.8, touchdown, 1.4])
    quat = Rotation.from_euler("z", yaw).as_quat(scalar_first=True)
    return Replan(
        measured=applied - 0.02,
        applied=applied,
        computing_time=0.01,
        solved=True,
        iterations=3,
        touchdown=touchdown,
        time=knots,
        com=np.zeros((4, 3)),
        base_quat=np.tile(quat, (4, 1)),
        foot_position=np.full((4, 4, 3), 0.03),
        foot_quat=np.tile([1.0, 0, 0, 0], (4, 4, 1)),
    )


def test_the_newest_plan_that_is_followed_says_when_and_in_which_attitude(plan, rollout):
    first, second = replan(0.5), replan(0.6, touchdown=0.85, yaw=-1.0)
    late = replace(replan(0.55), applied=np.nan)
    replanned = replace(rollout, replans=(first, late, second))
    assert followed(replanned.replans, 0.49) is None
    for time, newest in ((0.55, first), (0.65, second)):
        assert followed(replanned.replans, time) is newest
        expected = expected_touchdown(replanned, plan, ROBOT, time)
        assert expected.time == newest.touchdown
        assert expected.base_quat == pytest.approx(newest.base_quat[0])
        assert expected.ground == pytest.approx(np.full(4, 0.03))
