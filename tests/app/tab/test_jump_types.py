"""Jumps of another type, as values: chosen, undone, on another robot."""

import math
from dataclasses import replace

import pytest

from app.link import PlaybackChosen
from app.panel.acts import Act
from app.panel.status import Verdict
from app.tab.acts import SLOW_MOTION
from app.tab.effects import SetPlayback
from app.workers.tasks import PlanJump
from llsrbm.request import jump_types
from llsrbm.request.design import Design
from llsrbm.request.jump import Jump
from tests.app.pure_tab import PureTab, planned_tab

BACK = -2 * math.pi


@pytest.fixture
def tab():
    return planned_tab()


def test_a_type_comes_with_its_defaults_and_is_planned_from_scratch(tab):
    tab.move(type="run-up")
    jump = tab.state.design.jump
    assert (jump.type, jump.forward) == ("run-up", 0.01)
    assert jump.speed == jump_types.load_type("run-up").defaults["speed"] > 0
    assert tab.task == PlanJump(jump)


def test_what_a_type_does_not_ask_for_goes(tab):
    tab.move(robot="go2")
    tab.settle()
    tab.move(type="flip")
    assert tab.state.design.jump.pitch == BACK
    tab.settle()
    tab.move(type="hops")
    jump = tab.state.design.jump
    assert (jump.pitch, jump.hops) == (0.0, 2)
    tab.settle()
    tab.move(type="together")
    assert tab.state.design.jump == replace(jump, type="together", hops=1)


def test_a_number_of_the_type_is_a_number_like_others(tab):
    tab.move(type="run-up")
    tab.settle()
    shown = tab.state.plan
    tab.move(speed=0.6)
    assert tab.task == PlanJump(tab.state.design.jump, near=shown, patient=False)
    tab.take(Act.UNDO)
    assert tab.state.design.jump == shown.jump
    tab.take(Act.UNDO)
    assert tab.state.design.jump.type == "together"
    tab.take(Act.REDO)
    assert tab.state.design.jump == shown.jump


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ({"type": "flip"}, {"pitch": -BACK}),
        ({"type": "hops"}, {"hops": 3}),
    ],
)
def test_a_plan_of_other_phases_or_turns_is_no_start(tab, before, after):
    tab.move(robot="go2")
    tab.settle()
    tab.move(**before)
    tab.settle()
    tab.move(**after)
    assert tab.task == PlanJump(tab.state.design.jump)


def test_an_order_of_feet_is_together_instead_as_each_has_a_solver_of_its_own(tab):
    tab.move(robot="go2")
    tab.settle()
    tab.move(type="all - hind - none - front - all", forward=0.2)
    assert tab.task.jump.type == "together"
    assert tab.state.work.instead.startswith('"all - hind - none - front - all" is no preset.')


def test_a_type_stays_on_another_robot_within_its_ranges(tab):
    tab.move(type="hops", forward=0.6)
    tab.settle()
    tab.move(robot="go2")
    tab.settle()
    jump = tab.state.plan.jump
    assert (jump.robot, jump.type, jump.hops) == ("go2", "hops", 2)
    assert jump.forward == min(0.6, tab.state.file.task.forward[1])


def test_a_type_without_feet_on_another_robot_is_told_and_together_instead(tab):
    tab.move(type="rear-last")
    tab.settle()
    tab.move(robot="slider")
    tab.finish_robot()
    assert tab.state.design.jump.type == "together"
    assert tab.task.jump.type == "together"
    said = 'SLIDER does not support "Rear last". Planning "All feet together" instead.'
    assert tab.told == (Verdict.PLANNING, f"{said} ...")
    tab.finish_plan()
    assert tab.told == (Verdict.DRAFT, f"{said} Its drives were looked at in knots only.")
    tab.move(forward=0.05)
    tab.settle()
    assert tab.told[1] == "as its drives were looked at in knots only"


def test_a_design_of_a_type_that_its_robot_lacks_is_told_too():
    tab = PureTab("slider")
    tab.take(Design(Jump(robot="slider", type="rear-last"), title="Odd"))
    assert tab.told[1].startswith('SLIDER does not support "Rear last"')
    assert tab.state.design == Design(Jump(robot="slider"))


def test_flips_play_in_slow_motion_unless_a_pace_was_chosen(tab):
    tab.move(robot="go2")
    tab.settle()
    tab.move(type="flip")
    assert tab.state.playback.speed == SLOW_MOTION
    assert SetPlayback(SLOW_MOTION, loop=True) in tab.effects
    tab.settle()
    tab.move(type="together")
    assert tab.state.playback.speed == 1.0
    tab.take(PlaybackChosen(0.5, loop=True))
    tab.settle()
    tab.move(type="flip")
    assert tab.state.playback.speed == 0.5
