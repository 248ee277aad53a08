from __future__ import annotations

import pytest

from app.motion import colours
from app.motion.planned_motion import bake_plan
from app.motion.simulated_motion import bake_rollout
from app.session.pins import Pins
from llsrbm.design import Design
from llsrbm.jump import Jump
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout

JUMP = Jump(robot="anymal", twist=1.0)


@pytest.fixture(scope="module")
def robot():
    return load_robot("anymal")


@pytest.fixture(scope="module")
def replay(robot):
    return bake_plan(synthetic_plan(JUMP), robot)


@pytest.fixture
def pins(replay):
    made = Pins()
    for _ in colours.PINNED:
        assert not made.full
        made.add(replay, None, Design(JUMP))
    return made


def test_each_pin_has_a_colour_of_its_own_until_there_is_none_left(pins):
    assert [pin.colour for pin in pins] == list(colours.PINNED)
    assert pins.full


def test_a_colour_that_is_let_go_is_given_again_and_the_others_stay(pins, replay):
    middle = pins.at(1)
    pins.remove(middle)
    assert [pin.colour for pin in pins] == [colours.PINNED[0], colours.PINNED[2]]
    pins.add(replay, None, Design(JUMP))
    assert pins.at(2).colour == middle.colour
    assert pins.full


@pytest.mark.parametrize("index", [-1, 3, 99])
def test_there_is_no_such_pin(pins, index):
    assert pins.at(index) is None


def test_a_simulation_is_drawn_in_place_of_its_plan(replay):
    simulated = bake_rollout(synthetic_rollout(replay.plan))
    pins = Pins()
    pins.add(replay, simulated, Design(JUMP))
    pins.add(replay, None, Design(JUMP))
    with_it, without = pins
    assert with_it.ghost.frames is simulated.frames
    assert without.ghost.frames is replay.frames
    assert (with_it.rollout, without.rollout) == (simulated.rollout, None)
    assert with_it.figures != without.figures
