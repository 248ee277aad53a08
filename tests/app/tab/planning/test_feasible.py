"""The tint of the sliders: what is sent to the page, and what a tab learns."""

import math
from dataclasses import replace

import pytest

from app.tab.planning.feasible import Tint, learn
from app.workers.reports import Planned, Refused
from app.workers.tasks import PlanJump, RefinePlan
from llsrbm.atlas.tracks import tracks
from llsrbm.planning.whole_body.feasible import feasible_of
from llsrbm.robots import load_robot
from tests.app.pure_tab import plan_of, planned_tab
from tests.app.synthetic_plan import refined_plan
from tests.llsrbm.atlas.classifiers import learned_of

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
    with learned_of(load_robot("anymal")):
        yield planned_tab(twist=0.5)


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
    tab.move(forward=0.1)
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


def test_without_a_table_the_sliders_say_so_and_nothing_is_learned(page):
    with learned_of():
        tab = planned_tab()
        Tint(page, SLIDERS).draw(tab.state)
        refused = replace(tab.state.design.jump, twist=3.0)
        task = PlanJump(refused)
        assert learn(tab.state, Refused(1, refused, "no", plan_of(refused)), task) is tab.state
    (sent,) = page.shown
    said = {
        "chances": [],
        "text": "Which values can be planned is not known of this robot",
        "range": "",
    }
    assert sent == dict.fromkeys(SLIDERS.values(), said)


def test_whole_bodies_plans_and_refusals_are_learned_and_drafts_are_not(tab):
    robot, jump = tab.state.robot, tab.state.design.jump
    hard, less = replace(jump, twist=math.pi), replace(jump, twist=0.7 * math.pi)

    def taught(state, report, task):
        return learn(state, report, task).feasible.get("anymal", feasible_of(robot))

    known = feasible_of(robot)
    draft = plan_of(hard)
    assert taught(tab.state, Planned(1, draft), PlanJump(hard)) is known
    no = Refused(1, jump, "no", plan_of(jump, "not-converged"))
    assert taught(tab.state, no, PlanJump(jump, patient=False)) is known
    assert len(taught(tab.state, no, PlanJump(jump)).amounts) == 1
    certified = refined_plan(plan_of(less))
    found = taught(tab.state, Planned(1, certified), RefinePlan(draft, hard))
    assert len(found.amounts) == 1  # that the hard one cannot be done it knew
    assert tracks(hard, {}, robot, found)["twist"].intervals[0][1] > less.twist
    broken = Planned(1, replace(certified, certificate=None))
    (amount,) = taught(tab.state, broken, RefinePlan(draft, jump)).amounts
    assert amount < 0


def test_beyond_the_usual_requests_a_track_is_plain_and_its_sentence_is_of_what_is_known(tab, page):
    tab.move(forward=0.9)
    Tint(page, SLIDERS).draw(tab.state)
    track = page.shown[0]["id of forward"]
    known = [chance for chance in track["chances"] if chance is not None]
    share = len(known) / len(track["chances"])
    assert share == pytest.approx(0.9 / 1.2, abs=0.02)
    assert track["chances"][: len(known)] == known
    assert "whole slider" not in track["text"]
    assert None not in page.shown[0]["id of lateral"]["chances"]


def test_while_another_robot_is_loaded_no_track_is_of_the_one_before(tab, page):
    tint = Tint(page, SLIDERS)
    tint.draw(tab.state)
    tab.move(robot="slider")
    assert not tab.state.ready
    tint.draw(tab.state)
    tint.draw(tab.state)
    assert len(page.shown) == 2
    assert set(page.shown[1]) == {*SLIDERS.values()}
    for shown in page.shown[1].values():
        assert (shown["chances"], shown["range"]) == ([], "")
        assert "before the robot is loaded" in shown["text"]
