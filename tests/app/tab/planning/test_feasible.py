"""The tint of the sliders: what is sent to the page, and what a tab learns."""

import math

import pytest

from app.tab.planning.feasible import Tint
from app.workers.reports import Refused
from llsrbm.atlas.feasible import feasible_of
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from tests.app.pure_tab import plan_of, planned_tab
from tests.llsrbm.atlas.classifiers import shipped

WEAK = Tuning(limits={"torque_share": 0.4})
SLIDERS = {name: f"id of {name}" for name in ("twist", "forward", "lateral", "height")}


class Page:
    def __init__(self):
        self.shown = []

    def call(self, name, tracks):
        assert name == "tint.show"
        self.shown.append(tracks)


@pytest.fixture
def tab():
    """Of the robot of which alone something is known."""
    with shipped(load_robot("anymal")):
        yield planned_tab()


@pytest.fixture
def page():
    return Page()


def test_tracks_are_sent_when_the_request_changes_and_only_then(tab, page):
    tint = Tint(page, SLIDERS)
    tint.draw(tab.state)
    tint.draw(tab.state)
    assert len(page.shown) == 1
    assert set(page.shown[0]) == {*SLIDERS.values()}
    assert "over the whole slider" in page.shown[0]["id of forward"]["text"]
    tab.take(WEAK)
    tint.draw(tab.state)
    twist = page.shown[1]["id of twist"]
    assert min(twist["chances"]) < 50 < max(twist["chances"]) <= 100
    assert twist["text"].startswith("Can be planned from −")
    tab.move(type="hops", hops=2)
    tint.draw(tab.state)
    assert page.shown[-1]["id of twist"] == {
        "chances": [],
        "text": "Which values can be planned is not known of this type of jump",
        "range": "",
    }


def test_where_none_ships_the_sliders_say_so_and_nothing_is_learned(page):
    tab = planned_tab()
    Tint(page, SLIDERS).draw(tab.state)
    (sent,) = page.shown
    said = {
        "chances": [],
        "text": "Which values can be planned is not known of this robot",
        "range": "",
    }
    assert sent == dict.fromkeys(SLIDERS.values(), said)
    assert not tab.state.feasible


def test_a_refusal_against_the_guess_is_learned_and_so_is_a_plan(tab):
    robot = tab.state.robot
    tab.move(twist=0.5)
    tab.settle()
    assert tab.state.feasible.get("anymal", feasible_of(robot)) is feasible_of(robot)
    tab.take(WEAK)
    tab.move(twist=math.pi, forward=0.5)
    tab.settle()  # the planner of tests can do anything
    learned = tab.state.feasible["anymal"]
    assert len(learned.amounts) >= 1
    tab.state = tab.state.forgetting()
    tab.move(twist=0.1)
    submit = tab.submits[-1]
    refused = submit.task.jump
    last = plan_of(refused, "not-converged")
    tab.report(Refused(submit.ticket, refused, "no", last))
    if not submit.task.patient:  # a hand may still be moving: it may yet be found
        assert tab.state.feasible["anymal"] is learned
