import math
from dataclasses import replace

import pytest

from app.panel.jump_types import (
    not_supported,
    surface_fields,
    turn_title,
    turns_offered,
    types_offered,
    with_turn,
    with_type,
)
from llsrbm.request import jump_types
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from llsrbm.robots.schema import robot_files
from tests.llsrbm.robots.edited import rolling

TURNS = ("back flip", "front flip", "roll left", "roll right")
TURNING = {"flip", "caught-flip", "barrel-roll"}


def test_a_robot_that_turns_about_both_axes_can_do_every_preset(tmp_path):
    assert list(types_offered(rolling(tmp_path))) == list(jump_types.names())


def test_no_shipped_robot_rolls():
    """Go2's hips would need 27 of 21 Nm."""
    for name in robot_files():
        assert "barrel-roll" not in types_offered(load_robot(name))
    assert set(jump_types.names()) - set(types_offered(load_robot("go2"))) == {"barrel-roll"}
    assert not_supported(load_robot("go2"), "barrel-roll").startswith(
        'Unitree Go2 does not support "Barrel roll". '
    )


def test_a_robot_that_does_not_turn_over_has_no_flips():
    assert set(jump_types.names()) - set(types_offered(load_robot("anymal"))) == TURNING


def test_a_biped_has_no_hind_feet():
    offered = types_offered(load_robot("slider"))
    assert next(iter(offered)) == "together"
    # A back flip, the flip's default, pushes last with them.
    assert set(jump_types.names()) - set(offered) == {"rear-last", "leap"} | TURNING


def test_a_type_keeps_the_landing_place():
    jump = with_type(Jump(robot="go2", twist=0.5, forward=0.2, speed=0.3), "hops")
    assert jump == Jump(robot="go2", type="hops", twist=0.5, forward=0.2, hops=2)


def test_a_type_that_passes_over_something_has_level_surfaces():
    sloping = Jump(robot="go2", forward=0.5, slope=0.1, takeoff_cross_slope=0.1)
    assert with_type(sloping, "hurdle") == Jump(robot="go2", type="hurdle", forward=0.5)
    assert surface_fields(Jump(type="over-gap")) == ()
    assert with_type(sloping, "rear-last") == replace(sloping, type="rear-last")


@pytest.mark.parametrize("title", TURNS)
def test_a_turn_of_the_menu_is_shown_by_its_title(title):
    assert turn_title(with_turn(Jump(type="flip"), title)) == title


def test_turns_follow_the_right_hand_rule():
    # About y to the left a positive turn takes the nose down; about x ahead, the left side up.
    jump = Jump(type="flip")
    assert with_turn(jump, "front flip") == replace(jump, pitch=2 * math.pi)
    assert with_turn(jump, "roll right") == replace(jump, roll=2 * math.pi)


def test_other_turns_are_shown_in_degrees():
    assert turn_title(Jump(pitch=4 * math.pi, roll=-2 * math.pi)) == "pitch 720°, roll -360°"
    assert turn_title(Jump()) == "none"


def test_turns_about_which_the_robot_has_no_plans_are_not_offered(tmp_path):
    assert turns_offered(("pitch", "roll"), rolling(tmp_path).file.turning_axes) == TURNS
    assert turns_offered(("pitch", "roll"), load_robot("go2").file.turning_axes) == TURNS[:2]
    assert turns_offered(("pitch", "roll"), load_robot("anymal").file.turning_axes) == ()
