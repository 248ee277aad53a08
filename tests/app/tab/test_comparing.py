"""One jump made in several ways beside each other, as values."""

from __future__ import annotations

from dataclasses import replace

import pytest

from app.link import ComparisonClosed, PageReady
from app.panel.acts import Act
from app.plots.choice import PRESETS
from app.tab.acts import is_visible
from app.tab.contenders import card
from app.tab.effects import Play, Queue, Seek, Stop
from app.tab.plotting import layers_of
from app.tab.rendering import picture_of
from app.tab.start.opening import left, resume
from app.workers.reports import Cancelled, Failed, Planned, Progress, Refused, Simulated
from app.workers.tasks import TryWay
from llsrbm.request.scenario import Push, Scenario
from tests.app.pure_tab import plan_of, planned_tab, rollout_of
from tests.app.synthetic_plan import refined_plan


@pytest.fixture
def tab():
    return planned_tab(twist=1.0)


def tried(tab):
    """The task that is being worked on."""
    return tab.submits[-1].task


def finish(tab):
    """What is tried comes."""
    task = tried(tab)
    assert isinstance(task, TryWay)
    plan = task.plan or replace(plan_of(task.jump), tuning=task.tuning)
    rollout = replace(rollout_of(plan_of(plan.jump)), plan=plan, scenario=task.scenario)
    return tab.report(Simulated(0, rollout))


def compare(tab, act=Act.COMPARE_MODELS):
    tab.take(act)
    while tab.state.comparing.ticket:
        finish(tab)
    return tab.state.comparing


def test_each_model_plans_and_is_simulated_and_the_sentence_has_the_figures(tab):
    tab.take(Act.COMPARE_MODELS)
    models = []
    while tab.state.comparing.ticket:
        assert tab.submits[-1].queue is Queue.COMPARE
        models.append(tried(tab).jump.model)
        finish(tab)
    assert models == ["srbm", "llsrbm", "llsrbm-plus"]
    assert tab.of(Play)
    assert tab.of(Seek)
    shown = card(tab.state.comparing)
    assert [way["name"] for way in shown["ways"]] == ["SRBM", "LL-SRBM", "LL-SRBM+"]
    assert shown["sentence"].startswith("At touchdown SRBM has turned 2.9° less than planned (")
    assert len(shown["rows"][0]["values"]) == 3


def test_a_draft_that_is_there_is_not_planned_again(tab):
    tab.take(Act.COMPARE_MODELS)
    plans = []
    while tab.state.comparing.ticket:
        plans.append(tried(tab).plan)
        finish(tab)
    assert plans == [None, None, tab.state.plan]


def test_the_whole_bodys_plan_is_one_of_them(tab):
    whole = refined_plan(tab.state.plan)
    shown = replace(tab.state.shown, planned=replace(tab.state.shown.planned, plan=whole))
    tab.state = replace(tab.state, shown=shown)
    comparing = compare(tab)
    assert [each.name for each in comparing.contenders][-1] == "Whole body"
    assert comparing.last.solid.plan is whole
    assert comparing.contenders[2].solid.plan is not whole


def test_the_picture_and_the_charts_are_of_all_that_is_there(tab):
    before = picture_of(tab.state)
    tab.take(Act.COMPARE_MODELS)
    assert picture_of(tab.state).row == ()
    finish(tab)
    assert [each.title for each in picture_of(tab.state).row] == ["SRBM"]
    while tab.state.comparing.ticket:
        finish(tab)
    picture = picture_of(tab.state)
    assert [each.title for each in picture.row] == ["SRBM", "LL-SRBM", "LL-SRBM+"]
    assert len({each.colour for each in picture.row}) == 3
    assert picture.solid is picture.row[-1].frames
    assert picture.layers == {"ellipsoids"}
    titles = [layer.title for layer in layers_of(tab.state)]
    assert titles == [
        f"{name}{kind}" for name in ("SRBM", "LL-SRBM", "LL-SRBM+") for kind in (", plan", "")
    ]
    assert [chart.signal for chart in tab.state.plots_seen.charts] == [
        "inertia",
        "angular_velocity",
    ]
    tab.take(ComparisonClosed())
    assert tab.of(Stop) == [Stop(Queue.COMPARE)]
    assert picture_of(tab.state).planned is before.planned
    assert picture_of(tab.state).row == ()


def test_charts_chosen_meanwhile_are_the_comparisons(tab):
    plots = tab.state.plots
    compare(tab)
    tab.take(PRESETS["Base rates"])
    assert tab.state.plots_seen.charts == PRESETS["Base rates"].charts
    tab.take(ComparisonClosed())
    assert tab.state.plots_seen == plots


def test_a_model_that_finds_no_plan_is_said_and_the_others_go_on(tab):
    tab.take(Act.COMPARE_MODELS)
    jump = tried(tab).jump
    tab.report(Refused(0, jump, "the knees need 18 rad/s", plan_of(jump, "not-converged")))
    tab.report(Failed(0, "the server is busy"))
    finish(tab)
    shown = card(tab.state.comparing)
    assert shown["sentence"].startswith(
        "SRBM has no plan (the knees need 18 rad/s); LL-SRBM has no plan (the server is busy); "
        "at touchdown LL-SRBM+ has turned"
    )
    assert [each.title for each in picture_of(tab.state).row] == ["LL-SRBM+"]


def test_while_it_is_tried_its_progress_is_told(tab):
    tab.take(Act.COMPARE_MODELS)
    tab.report(Progress(0, "simulating, 31 %"))
    shown = card(tab.state.comparing)
    assert shown["note"] == "SRBM: simulating, 31 % ..."
    assert shown["sentence"] == ""
    assert [way["state"] for way in shown["ways"]] == ["busy", "waits", "waits"]


@pytest.mark.parametrize(
    "event", [Act.SIMULATE, Scenario(board=0.02), Act.UNDO, ComparisonClosed()]
)
def test_it_ends_with_another_design_or_simulation(tab, event):
    compare(tab)
    tab.take(event)
    assert tab.state.comparing is None
    assert card(tab.state.comparing) is None


def test_reports_of_one_that_was_closed_count_no_more(tab):
    tab.take(Act.COMPARE_MODELS)
    late = tab.submits[-1]
    tab.take(ComparisonClosed())
    tab.report(Cancelled(0), submit=late)
    assert tab.state.comparing is None
    tab.take(Act.COMPARE_MODELS)
    before = tab.state
    tab.report(Planned(0, tab.state.plan), submit=late)
    assert tab.state is before


def test_replanning_is_compared_on_the_plan_that_is_shown(tab):
    assert not is_visible(Act.COMPARE_REPLANNING, tab.state)
    tab.take(Scenario(pushes=(Push(0.5, (0.0, 9.0, 0.0)),)))
    assert is_visible(Act.COMPARE_REPLANNING, tab.state)
    comparing = compare(tab, Act.COMPARE_REPLANNING)
    assert [each.solid.rollout.scenario.replan for each in comparing.contenders] == [False, True]
    assert all(each.solid.plan is tab.state.plan for each in comparing.contenders)
    assert all(each.solid.rollout.scenario.pushes for each in comparing.contenders)
    assert card(comparing)["sentence"].startswith("At touchdown the robot has turned")


def test_drives_are_compared_on_the_plan_that_is_shown(tab):
    comparing = compare(tab, Act.COMPARE_DRIVES)
    assert [each.name for each in comparing.contenders] == ["Ideal drives", "True drives"]
    drives = [each.solid.rollout.scenario.drives for each in comparing.contenders]
    assert drives == ["ideal", "true"]


def test_arms_are_compared_by_plans_of_their_own(tab):
    assert not is_visible(Act.COMPARE_ARMS, tab.state)
    tab = planned_tab(robot="g1")
    assert is_visible(Act.COMPARE_ARMS, tab.state)
    comparing = compare(tab, Act.COMPARE_ARMS)
    assert [each.solid.plan.jump.arms for each in comparing.contenders] == ["held", "free"]


def test_a_tab_that_comes_back_goes_on_with_it(tab):
    tab.take(Act.COMPARE_MODELS)
    finish(tab)
    tab.have(resume(left(tab.state), PageReady(software=True)))
    assert tried(tab).jump.model == "llsrbm"
    while tab.state.comparing.ticket:
        finish(tab)
    assert len(tab.state.comparing.present) == 3
