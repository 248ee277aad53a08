"""What is pinned beside the present design, as values."""

import pytest

from app.link import BesideChosen, PinPressed
from app.motion.colours import PINNED
from app.panel.acts import Act
from app.tab.acts import is_enabled
from app.tab.comparison import PinChosen
from app.tab.rendering import picture_of
from app.tab.state import TabState
from llsrbm.look.titles import decisions_of
from llsrbm.request.scenario import Scenario
from tests.app.pure_tab import PureTab, planned_tab


@pytest.fixture
def tab():
    return planned_tab()


def pin_at(tab, *places):
    for forward in places:
        tab.move(forward=forward)
        tab.settle()
        tab.take(Act.PIN)
    return tab


def places(state: TabState):
    return [pin.design.jump.forward for pin in state.pins]


def test_a_pin_keeps_the_motion_and_all_that_was_asked_for(tab):
    tab.take(Scenario(board=0.02))
    tab.take(Act.PIN)
    (pin,) = tab.state.pins
    assert pin.design == tab.state.design
    assert pin.motion is tab.state.shown.planned
    assert pin.rollout is None
    assert pin.ghost.frames is tab.state.shown.planned.frames
    assert pin.ghost.colour == pin.colour == PINNED[0]
    assert pin.decisions == decisions_of(tab.state.plan)


def test_a_pinned_simulation_keeps_the_scenario_it_ran_in(tab):
    tab.take(Scenario(board=0.02))
    tab.take(Act.SIMULATE)
    tab.finish_simulation()
    tab.take(Scenario())
    tab.take(Act.PIN)
    (pin,) = tab.state.pins
    assert pin.rollout is tab.state.rollout
    assert pin.design.scenario == Scenario(board=0.02)
    assert pin.ghost.frames is tab.state.shown.simulated.frames
    assert pin.figures is pin.figures


def test_there_are_no_more_pins_than_colours(tab):
    pin_at(tab, 0.05, 0.1, 0.15)
    assert [pin.colour for pin in tab.state.pins] == list(PINNED)
    assert not is_enabled(Act.PIN, tab.state)
    before = tab.state
    tab.take(Act.PIN)
    assert tab.state is before


def test_a_colour_that_was_let_go_is_taken_again(tab):
    pin_at(tab, 0.05, 0.1, 0.15)
    tab.take(PinChosen(1))
    tab.take(Act.UNPIN)
    assert places(tab.state) == [0.05, 0.15]
    assert tab.state.pin_chosen == 1
    pin_at(tab, 0.2)
    assert tab.state.pins[-1].colour == PINNED[1]
    for _ in range(4):
        tab.take(Act.UNPIN)
    assert (tab.state.pins, tab.state.pin_chosen) == ((), -1)


def test_without_a_motion_nothing_is_pinned():
    tab = PureTab()
    tab.take(Act.PIN)
    assert tab.state.pins == ()


@pytest.mark.parametrize("index", [-1, 5])
def test_no_pin_is_chosen(tab, index):
    pin_at(tab, 0.05)
    tab.take(PinChosen(index))
    assert tab.state.pin_chosen == -1
    assert tab.take(Act.USE_PINNED) == ()


def test_the_chosen_pin_is_taken_up(tab):
    pin_at(tab, 0.05, 0.1)
    tab.take(PinChosen(0))
    tab.take(Act.USE_PINNED)
    assert tab.task.jump.forward == 0.05
    assert places(tab.state) == [0.05, 0.1]


def test_a_pins_chip_uses_its_design_and_lets_go_of_it(tab):
    pin_at(tab, 0.05, 0.1)
    tab.take(PinPressed("use", 0))
    assert tab.task.jump.forward == 0.05
    tab.take(PinPressed("unpin", 0))
    assert places(tab.state) == [0.1]
    before = tab.state
    for act in ("use", "unpin"):  # it has gone meanwhile
        tab.take(PinPressed(act, 1))
    assert tab.state is before


def test_pinned_robots_stand_where_they_are_or_beside(tab):
    pin_at(tab, 0.05, 0.1)
    assert len(picture_of(tab.state).ghosts) == 2
    assert picture_of(tab.state).row == ()
    tab.take(BesideChosen(True))
    beside = picture_of(tab.state)
    assert beside.ghosts == ()
    assert beside.row[0].frames is beside.solid
    assert [each.frames for each in beside.row[1:]] == [pin.ghost.frames for pin in tab.state.pins]
    assert [each.colour for each in beside.row[1:]] == [pin.colour for pin in tab.state.pins]
    assert len({each.title for each in beside.row}) == 3
    tab.take(BesideChosen(False))
    assert picture_of(tab.state).row == ()
