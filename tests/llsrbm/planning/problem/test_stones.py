"""Feet that land beside where they would by themselves: where that is, and where they cannot."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from llsrbm.errors import InputError
from llsrbm.mechanics import turns_about_z
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.stones import LEAN, RISE, within_reach
from llsrbm.request.jump import Jump
from llsrbm.request.stones import Stone
from llsrbm.robots import load_robot

ROBOT = load_robot("anymal")
JUMP = Jump(twist=1.2, forward=0.3, lateral=0.1, height=0.1)
ASIDE = {"RF": (0.05, -0.03, 0.04)}
reachable = st.floats(-0.5, 0.5)


@pytest.mark.parametrize("jump", [JUMP, replace(JUMP, type="hops", hops=2)], ids=["one", "two"])
def test_that_foot_alone_lands_elsewhere_as_the_robot_looks_that_lands(jump):
    plain, moved = (make_task(each, ROBOT) for each in (jump, replace(jump, stones=ASIDE)))
    away = np.zeros((4, 3))
    away[1] = turns_about_z(plain.places[-1].heading) @ ASIDE["RF"]
    last, other = plain.places[-1], moved.places[-1]
    np.testing.assert_allclose(other.feet - last.feet, away, atol=1e-12)
    np.testing.assert_allclose(other.contacts - last.contacts, away, atol=1e-12)
    for before, after in zip(plain.places[:-1], moved.places[:-1], strict=True):
        np.testing.assert_array_equal(before.feet, after.feet)
    # A quarter of the one foot's height is the plane's above the middle; the body takes its share.
    rises = moved.goal_position - plain.goal_position
    np.testing.assert_allclose(rises, [0.0, 0.0, RISE * ASIDE["RF"][2] / 4], atol=5e-4)


def _R(quat):
    return Rotation.from_quat(np.roll(quat, -1)).as_matrix()


@pytest.mark.parametrize("twist", [0.0, 2.1])
def test_a_body_leans_part_of_the_way_with_its_feet(twist):
    stairs = {"LF": (0.0, 0.0, 0.12), "RF": (0.0, 0.0, 0.12)}
    plain, moved = (make_task(Jump(twist=twist, stones=stones), ROBOT) for stones in ({}, stairs))
    nose = (_R(plain.goal_quat).T @ _R(moved.goal_quat))[:, 0]  # as the level robot sees it
    base = ROBOT.feet[0, 0] - ROBOT.feet[2, 0]
    np.testing.assert_allclose(nose[2] / nose[0], LEAN * 0.12 / base, rtol=1e-6)
    assert abs(nose[1]) < 1e-9
    assert moved.lean(-1) == pytest.approx((-np.arctan(nose[2] / nose[0]), 0.0))
    np.testing.assert_allclose(moved.places[-1].feet[:, :2], plain.places[-1].feet[:, :2])
    assert not moved.places[-1].tilt.any()  # every step is level


@pytest.mark.parametrize("name", ["slider", "g1"])
@pytest.mark.parametrize("twist", [0.0, 2.1])
def test_on_soles_a_body_stands_upright_above_the_middle_of_its_feet(name, twist):
    robot = load_robot(name)
    first, second = robot.leg_names
    stones = {first: (0.06, 0.05, 0.03), second: (-0.02, 0.01, 0.0)}
    plain, moved = (
        make_task(Jump(robot=name, twist=twist, stones=each), robot) for each in ({}, stones)
    )
    middles = [task.places[-1].feet.mean(axis=0)[:2] for task in (plain, moved)]
    away = moved.goal_position - plain.goal_position
    np.testing.assert_allclose(away[:2], middles[1] - middles[0], atol=1e-12)
    assert away[2] == 0.0
    np.testing.assert_array_equal(moved.goal_quat, plain.goal_quat)


def test_over_stones_of_one_height_the_body_takes_its_share_of_it():
    stones = dict.fromkeys(ROBOT.leg_names, (0.0, 0.0, 0.05))
    moved, plain = (make_task(Jump(stones=each), ROBOT) for each in (stones, {}))
    np.testing.assert_allclose(moved.goal_quat, plain.goal_quat, atol=1e-12)
    np.testing.assert_allclose(moved.goal_position[2] - plain.goal_position[2], RISE * 0.05)


def test_corners_of_a_sole_move_with_it():
    jump = Jump(robot="slider", twist=0.4)
    aside = {"left": (0.03, 0.02)}
    plain, moved = (
        make_task(each, load_robot("slider")).places[-1]
        for each in (jump, replace(jump, stones=aside))
    )
    away = (moved.contacts - plain.contacts).reshape(2, -1, 3)
    np.testing.assert_allclose(away[0], (moved.feet - plain.feet)[[0]].repeat(4, axis=0))
    assert not away[1].any()


@pytest.mark.parametrize(
    ("stones", "reason"),
    [
        ({"FL": (0.1, 0.0)}, 'stones: anymal has no leg "FL"; valid: LF, RF, LH, RH'),
        ({"LF": (0.3, 0.0)}, r"LF would stand 0\.583 m from its hip.* expected 0\.26 to 0\.52 m"),
        ({"LH": (0.0, 0.0, 0.3)}, r"would stand .* as far as legs of anymal reach"),
        (
            {"LF": (0.0, -0.2), "RF": (0.0, 0.2)},
            r"LF and RF would stand 0\.\d+ m apart; expected at least 0\.12 m",
        ),
    ],
)
def test_where_no_foot_lands(stones, reason):
    with pytest.raises(InputError, match=reason):
        make_task(replace(JUMP, stones=stones), ROBOT)


def test_the_reach_is_the_requests_own():
    jump = replace(JUMP, stones={"LF": (0.1, 0.0)})
    make_task(jump, ROBOT)
    with pytest.raises(InputError, match="LF would stand"):
        make_task(jump, ROBOT, limits={"reach_x_max": 0.11})


@given(st.sampled_from(ROBOT.leg_names), reachable, reachable, st.floats(0, 0.1))
def test_a_foot_goes_as_far_as_its_leg_reaches(leg, dx, dy, dz):
    jump = within_reach(replace(JUMP, stones=ASIDE), Stone(leg, dx, dy, dz), ROBOT)
    make_task(jump, ROBOT)
    found = next((each for each in jump.stones if each.leg == leg), Stone(leg, 0.0, 0.0))
    assert np.hypot(found.dx, found.dy) <= np.hypot(dx, dy) + 1e-3
    if leg != "RF":
        assert Stone("RF", *ASIDE["RF"]) in jump.stones
    try:  # all the way, where that can be
        make_task(replace(JUMP, stones={**ASIDE, leg: (dx, dy, dz)}), ROBOT)
    except InputError:
        return
    assert found[1:] == pytest.approx((dx, dy, dz), abs=6e-4)
