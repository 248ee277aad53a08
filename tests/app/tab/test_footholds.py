"""Single feet's landing places, dragged and typed: which requests they become, and undone."""

import numpy as np

from app.panel.acts import Act
from app.picture.foothold_handles import FootholdDragged
from app.tab import acts
from llsrbm.planning.problem.placement import make_task
from tests.app.pure_tab import PureTab, planned_tab


def test_a_dragged_foot_is_planned_and_one_grip_is_one_step_back():
    tab = planned_tab()
    before = tab.state.design
    tab.take(FootholdDragged("LF", 0.0, 0.0, 1))
    for dx in (0.01, 0.02, 0.03):
        tab.take(FootholdDragged("LF", dx, 0.02, 1))
        tab.settle()  # the hand rests
    tab.take(FootholdDragged("LF", 0.03, 0.02, 1, held=False))
    assert tab.state.plan.jump.stones == (("LF", 0.03, 0.02, 0.0),)
    tab.move(stones=(("LF", 0.05, 0.02, 0.0),))  # typed
    tab.take(FootholdDragged("RH", -0.02, 0.0, 2))
    tab.settle()
    assert [stone.leg for stone in tab.state.plan.jump.stones] == ["LF", "RH"]
    for dx in (0.05, 0.03):
        tab.take(Act.UNDO)
        assert tab.state.design.jump.stones == (("LF", dx, 0.02, 0.0),)
    tab.take(Act.UNDO)
    assert tab.state.design == before


def test_twenty_edits_are_undone_to_the_last_bit():
    rng = np.random.default_rng(44)
    tab = planned_tab()
    before = []
    for grip, leg in enumerate(rng.choice(["LF", "RF", "LH", "RH"], 20).tolist(), start=1):
        before.append((tab.state.design, tab.state.shown))
        tab.take(FootholdDragged(leg, *rng.uniform(-0.5, 0.5, 2).tolist(), grip))
        make_task(tab.state.design.jump, tab.state.robot)  # which raises where no foot reaches
        tab.settle()
    for design, shown in reversed(before):
        tab.take(Act.UNDO)
        assert tab.state.design == design
        assert tab.state.shown is shown


def test_all_feet_land_by_themselves_again():
    tab = planned_tab()
    assert not acts.is_enabled(Act.RESET_FOOTHOLDS, tab.state)
    before = tab.state.design.jump
    tab.take(FootholdDragged("LF", 0.03, 0.02))
    assert acts.is_enabled(Act.RESET_FOOTHOLDS, tab.state)
    tab.settle()
    tab.take(Act.RESET_FOOTHOLDS)
    tab.settle()
    assert tab.state.plan.jump == before


def test_another_robot_has_other_feet():
    tab = planned_tab()
    tab.take(FootholdDragged("LF", 0.03, 0.02))
    tab.settle()
    tab.move(robot="go2", type="rear-last")
    assert tab.state.design.jump.stones == ()


def test_without_a_robot_nothing_is_dragged():
    tab = PureTab(robot="")
    before = tab.state
    assert tab.take(FootholdDragged("LF", 0.03, 0.02)) == ()
    assert tab.state is before
