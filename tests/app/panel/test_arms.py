"""The menu of robots with arms, spoken to as a browser (or a hostile script) would."""

import pytest

from llsrbm.request.design import load_design
from tests.app.raw_tab import choose, planned


@pytest.fixture
def tab(tab, session):
    """A tab of a robot with arms."""
    choose(tab, session, "g1")
    return tab


def is_there(tab):
    return tab.control("Arms")["props"]["visible"]


def hold(tab, session):
    tab.set("Arms", "Held")
    return planned(tab, session, lambda jump: jump.arms == "held", "a plan with held arms").jump


def test_it_is_there_for_robots_with_arms(tab, session):
    assert is_there(tab)
    assert tab.value("Arms") == "Free"
    choose(tab, session, "anymal")
    tab.wait(lambda: not is_there(tab), "no menu")


def test_it_plans_and_is_undone(tab, session):
    before = session.state.plan.jump
    assert hold(tab, session) != before
    tab.press("Undo")
    planned(tab, session, lambda jump: jump == before, "the plan before")
    tab.wait(lambda: tab.value("Arms") == "Free", "the menu as it was")


def test_a_file_and_a_pin_tell_of_held_arms(tab, session):
    tab.press("Pin")
    hold(tab, session)
    tab.wait(lambda: "arms held" in tab.text(), "the title beside the pin's")
    tab.press("Save design")
    tab.wait(lambda: tab.downloads, "the file")
    ((_, content),) = tab.downloads
    assert load_design(content).jump == session.state.design.jump
