"""One jump made in several ways beside each other, as values."""

from dataclasses import replace

import pytest

from app.link import ComparisonClosed, PageReady
from app.panel.acts import Act
from app.plots.choice import PRESETS
from app.tab.acts import is_visible
from app.tab.contenders import card
from app.tab.effects import Forget, Play, Queue, Seek
from app.tab.plotting import layers_of
from app.tab.rendering import picture_of
from app.tab.start.opening import left, resume
from app.workers.reports import Cancelled, Failed, Planned, Progress, Refused, Simulated
from app.workers.tasks import FollowWay, PlanWay
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Push, Scenario
from tests.app.pure_tab import plan_of, planned_tab, rollout_of
from tests.app.synthetic_plan import refined_plan


@pytest.fixture
def tab():
    return planned_tab(twist=1.0)


def tried(tab, place):
    """The job that is worked on for the one of a place, from the left."""
    ticket = tab.state.comparing.contenders[place].ticket
    (submit,) = [each for each in tab.submits if each.ticket == ticket]
    assert (submit.queue, submit.lane) == (Queue.COMPARE, place)
    return submit


def finish(tab, place):
    """The plan of one comes, if it was not there, and its simulation."""
    submit = tried(tab, place)
    if isinstance(submit.task, PlanWay):
        tab.report(planned(submit.task), submit=submit)
        submit = tried(tab, place)
    task = submit.task
    assert isinstance(task, FollowWay)
    rollout = replace(rollout_of(plan_of(task.plan.jump)), plan=task.plan, scenario=task.scenario)
    return tab.report(Simulated(0, rollout), submit=submit)


def planned(task):
    return Planned(0, replace(plan_of(task.jump), tuning=task.tuning))


def finish_all(tab):
    for place, each in enumerate(tab.state.comparing.contenders):
        if not each.done:
            finish(tab, place)
    return tab.state.comparing


def compare(tab, act=Act.COMPARE_MODELS):
    tab.take(act)
    return finish_all(tab)


def test_each_model_plans_and_is_simulated_and_the_sentence_has_the_figures(tab):
    comparing = compare(tab)
    models = [each.solid.plan.jump.model for each in comparing.contenders]
    assert models == ["srbm", "llsrbm", "llsrbm-plus"]
    assert tab.of(Play)
    assert tab.of(Seek)
    shown = card(tab.state.comparing)
    assert [way["name"] for way in shown["ways"]] == ["SRBM", "LL-SRBM", "LL-SRBM+"]
    assert shown["sentence"].startswith("At touchdown SRBM has turned 2.9° less than planned (")
    assert len(shown["rows"][0]["values"]) == 3


def test_they_are_tried_side_by_side_and_a_draft_that_is_there_is_simulated_at_once(tab):
    begun = tab.take(Act.COMPARE_MODELS)
    assert [type(each.task) for each in begun] == [FollowWay, PlanWay, PlanWay]
    assert [each.lane for each in begun] == [2, 0, 1]
    assert begun[0].task.plan is tab.state.plan
    tab.report(planned(tried(tab, 1).task), submit=tried(tab, 1))
    assert isinstance(tried(tab, 1).task, FollowWay)
    assert isinstance(tried(tab, 0).task, PlanWay)


def test_the_first_that_comes_plays_and_all_play_from_the_start_at_the_end(tab):
    tab.take(Act.COMPARE_MODELS)
    assert finish(tab, 2) == (Seek(0.0), Play())
    assert [each.title for each in picture_of(tab.state).row] == ["LL-SRBM+"]
    assert not [each for each in finish(tab, 0) if isinstance(each, Seek | Play)]
    assert [each.title for each in picture_of(tab.state).row] == ["SRBM", "LL-SRBM+"]
    assert finish(tab, 1)[-2:] == (Seek(0.0), Play())


def test_a_simulation_that_is_shown_is_not_made_again(tab):
    tab.take(Act.SIMULATE)
    tab.finish_simulation()
    tab.take(Act.COMPARE_DRIVES)
    ideal, true = tab.state.comparing.contenders
    assert true.shown is tab.state.shown
    assert not ideal.done
    tab.take(Scenario(board=0.02))
    tab.take(Act.COMPARE_DRIVES)
    assert not tab.state.comparing.present


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
    finish_all(tab)
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
    jump = tried(tab, 0).task.jump
    refused = Refused(0, jump, "the knees need 18 rad/s", plan_of(jump, "not-converged"))
    tab.report(refused, submit=tried(tab, 0))
    tab.report(Failed(0, "the server is busy"), submit=tried(tab, 1))
    finish(tab, 2)
    shown = card(tab.state.comparing)
    assert shown["sentence"].startswith(
        "SRBM has no plan (the knees need 18 rad/s); LL-SRBM has no plan (the server is busy); "
        "at touchdown LL-SRBM+ has turned"
    )
    assert [each.title for each in picture_of(tab.state).row] == ["LL-SRBM+"]


def test_while_it_is_tried_its_progress_is_told(tab):
    tab.take(Act.COMPARE_MODELS)
    assert card(tab.state.comparing)["note"] == "Planning and simulating ..."
    tab.report(Progress(0, "attempt 1"), submit=tried(tab, 0))
    tab.report(Progress(0, "waiting: attempt 1", waiting=True), submit=tried(tab, 1))
    tab.report(Progress(0, "simulating, 31 %"), submit=tried(tab, 2))
    shown = card(tab.state.comparing)
    assert shown["note"] == "SRBM: attempt 1; LL-SRBM+: simulating, 31 % ..."
    assert shown["sentence"] == ""
    assert [way["state"] for way in shown["ways"]] == ["busy", "waits", "busy"]


@pytest.mark.parametrize(
    "event", [Act.SIMULATE, Scenario(board=0.02), Act.UNDO, ComparisonClosed()]
)
def test_it_ends_with_another_design_or_simulation(tab, event):
    compare(tab)
    tab.take(event)
    assert tab.state.comparing is None
    assert card(tab.state.comparing) is None


@pytest.mark.parametrize("event", [ComparisonClosed(), Act.SIMULATE, Jump(twist=0.5)])
def test_what_it_had_under_way_is_given_up(tab, event):
    tab.take(Act.COMPARE_MODELS)
    assert not tab.of(Forget)
    tab.take(event)
    assert tab.of(Forget) == [Forget(Queue.COMPARE)]
    compare(tab)
    tab.take(ComparisonClosed())
    assert not tab.of(Forget)


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
    finish(tab, 0)
    tab.have(resume(left(tab.state), PageReady(software=True)))
    assert [each.lane for each in tab.effects if each in tab.submits] == [2, 1]
    assert len(finish_all(tab).present) == 3
