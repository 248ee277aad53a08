from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from llsrbm.errors import InputError
from llsrbm.planning.problem.costs import default_weights
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.parameters import parameters
from llsrbm.planning.problem.placement import check_turns, describe, make_task
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.llsrbm.robots.edited import rolling

ROBOT = load_robot("anymal")
ASKED = ROBOT.file.task
PARTS = ("twist", "forward", "lateral", "height")

requests = st.builds(Jump, **{name: st.floats(*getattr(ASKED, name)) for name in PARTS})


@settings(max_examples=20, deadline=None)
@given(jump=requests)
def test_the_goal_is_the_standing_robot_moved(jump):
    task = make_task(jump, ROBOT)
    turn = Rotation.from_rotvec([0, 0, jump.twist])
    shift = [jump.forward, jump.lateral, jump.height]
    np.testing.assert_allclose(task.start_position, ROBOT.com)
    start, goal = task.places
    np.testing.assert_allclose(start.feet, ROBOT.feet)
    np.testing.assert_allclose(task.goal_position, turn.apply(ROBOT.com) + shift, atol=1e-12)
    np.testing.assert_allclose(goal.feet, turn.apply(ROBOT.feet) + shift, atol=1e-12)
    attitude = Rotation.from_quat(task.goal_quat, scalar_first=True)
    assert (attitude.inv() * turn).magnitude() < 1e-9
    assert np.linalg.norm(task.goal_quat) == pytest.approx(1.0)


@given(twist=st.floats(ASKED.twist[0], ASKED.twist[1] - 1e-3), step=st.floats(1e-6, 1e-3))
@settings(max_examples=20, deadline=None)
def test_the_goal_quaternion_never_jumps(twist, step):
    one, two = (make_task(Jump(twist=t), ROBOT).goal_quat for t in (twist, twist + step))
    assert np.linalg.norm(two - one) <= step


def test_twists_beyond_half_a_turn_go_the_long_way():
    quat = make_task(Jump(twist=4.0), ROBOT).goal_quat
    np.testing.assert_allclose(quat, [np.cos(2.0), 0, 0, np.sin(2.0)])
    assert quat[0] < 0


RAD = " (in Python and in files in rad)"


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        (
            {"twist": np.radians(800)},
            f"twist 800 deg is out of range; expected -720 to 720 deg{RAD}",
        ),
        ({"twist": -13.0}, f"twist -744.845 deg is out of range; expected -720 to 720 deg{RAD}"),
        ({"forward": 50.0}, "forward 50 m is out of range; expected -3 to 3 m"),
        ({"lateral": -3.1}, "lateral -3.1 m is out of range; expected -3 to 3 m"),
        ({"height": 4.0}, "height 4 m is out of range; expected -3 to 3 m"),
    ],
)
def test_a_slip_of_units_is_refused(request_, message):
    with pytest.raises(InputError) as caught:
        make_task(Jump(**request_), ROBOT)
    assert str(caught.value) == message


@pytest.mark.parametrize("name", PARTS)
def test_what_the_robots_file_does_not_usually_ask_for_may_be_asked_for(name):
    beyond = 2 * getattr(ASKED, name)[1]
    assert getattr(make_task(Jump(**{name: beyond}), ROBOT).jump, name) == beyond


def test_weights_replace_the_defaults():
    task = make_task(Jump(), ROBOT, {"time": 3.0})
    assert task.weights == default_weights() | {"time": 3.0}
    layout = Layout.of(task.schedule, 4, 48, 3)
    assert parameters(layout, task)["weight_time"] == 3.0
    assert make_task(Jump(), ROBOT, {"time": 0}).weights["time"] == 0
    assert make_task(Jump(), ROBOT).weights == default_weights()


@pytest.mark.parametrize(
    ("weights", "parts"),
    [
        ({"tiem": 1.0}, ["unknown weight 'tiem'", *default_weights()]),
        ({"time": -1.0}, ["weight time", "at least 0", "-1.0"]),
        ({"time": np.nan}, ["weight time", "nan"]),
        ({"time": np.inf}, ["weight time", "inf"]),
    ],
)
def test_weights_that_are_none(weights, parts):
    with pytest.raises(InputError) as caught:
        make_task(Jump(), ROBOT, weights)
    assert "\n" not in str(caught.value)
    for part in parts:
        assert part in str(caught.value)


def test_whole_turns_are_those_of_the_robots_file(tmp_path):
    jump = Jump(type="barrel-roll", roll=2 * np.pi)
    check_turns(jump, rolling(tmp_path))
    with pytest.raises(InputError, match="the file of go2 allows pitch alone"):
        check_turns(jump, load_robot("go2"))
    flip = replace(jump, type="flip", roll=0.0, pitch=2 * np.pi)
    check_turns(flip, load_robot("go2"))


def test_a_request_in_words_is_its_jump_or_where_its_route_leads():
    assert describe(Jump(twist=np.pi / 2, forward=0.3)).startswith("twist 90 deg, forward 0.3 m,")
    route = [{"forward": 0.3, "twist": np.pi / 2}, {"forward": 0.2, "height": 0.1}]
    said = describe(Jump(robot="go2", route=route))
    assert said == "a route of 2 landings to (0.30, 0.20, 0.10) m, 90 deg, llsrbm-plus"
