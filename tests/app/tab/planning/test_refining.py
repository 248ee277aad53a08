"""The whole body's plan follows a draft that has rested, unless it is switched off."""

from dataclasses import replace

import pytest

from app.panel.acts import Act
from app.panel.status import Verdict
from app.tab.effects import Submit
from app.tab.planning.refining import WholeBody
from app.tab.simulating import Automatically
from app.tab.start.opening import TabOpened, example_design, first_state
from app.workers.reports import Cancelled, Planned, Progress, Refused
from app.workers.tasks import PlanJump, RefinePlan, SimulateJump
from llsrbm.certificate import Certificate, Finding
from tests.app.pure_tab import ROBOTS, PureTab, plan_of, planned_tab
from tests.app.synthetic_plan import refined_plan
from tests.llsrbm.atlas.classifiers import learned_of


def refining(**changes):
    """A tab that waits for the refinement of its plan."""
    tab = planned_tab(**changes)
    tab.take(WholeBody(True))
    assert isinstance(tab.submits[-1].task, RefinePlan)
    return tab


def finish(tab, status="solved"):
    task = tab.submits[-1].task
    return tab.report(Planned(0, refined_plan(task.plan, status)))


def test_the_plan_that_is_shown_is_refined_and_comes_back():
    tab = refining()
    centroidal = tab.state.plan
    assert tab.state.planning
    assert not tab.state.moving  # its charts and figures are drawn meanwhile
    assert tab.state.status.busy
    assert tab.told == (Verdict.DRAFT, "(the whole body's plan follows) ...")
    tab.report(Progress(0, "building the solver", lasts=10.0))
    assert tab.state.status.lasts == 10.0  # a bar says how long
    tab.report(Progress(0, "refining", iteration=3, residual=1e-3))
    assert tab.state.status.lasts is None
    assert tab.told == (Verdict.DRAFT, "(refining, step 3) ...")
    assert tab.state.status.figures[1] == ("Flight time", "0.500 s")
    finish(tab)
    assert tab.state.plan.refined
    assert tab.told == (Verdict.FEASIBLE, "")
    assert not tab.state.status.busy
    asked = len(tab.submits)
    tab.take(WholeBody(False))
    assert tab.state.plan is centroidal
    assert tab.told == (Verdict.DRAFT, "as its drives were looked at in knots only")
    assert len(tab.submits) == asked


@pytest.mark.parametrize("known", [False, True])
def test_a_plan_is_refined_when_its_request_has_rested_and_then_simulated(known):
    tab = refining(twist=0.5)
    finish(tab)
    tab.take(Automatically(True))
    tab.finish_simulation()
    tab.move(forward=0.1)
    tab.finish_plan()  # the quick one
    with learned_of(*([tab.state.robot] if known else [])):
        tab.wait()
    if not known:  # that the whole body does it
        assert isinstance(tab.submits[-1].task, PlanJump)
        tab.finish_plan()
    assert isinstance(tab.submits[-1].task, RefinePlan)
    assert not tab.state.plan.refined
    finish(tab)
    assert isinstance(tab.submits[-1].task, SimulateJump)
    assert tab.submits[-1].task.plan is tab.state.plan
    assert tab.state.plan.refined


def test_what_is_not_found_is_told_and_the_first_plan_stays():
    tab = refining()
    finish(tab, "not-converged")
    assert not tab.state.plan.refined
    assert tab.told == (Verdict.DRAFT, "as the whole body's plan was not found")


def test_a_certificate_that_does_not_hold_leaves_a_draft_and_the_reason():
    tab = refining()
    slips = Certificate((Finding("slip", 0.02, 0.01, "m", "RL", 0.3, False, 0.01),)).as_dict()
    plan = replace(refined_plan(tab.submits[-1].task.plan), certificate=slips)
    tab.report(Planned(0, plan))
    assert tab.told == (Verdict.DRAFT, "as its certificate does not hold: slip")


def test_it_is_on_by_default():
    assert first_state(ROBOTS).whole_body


def test_a_tab_begins_with_the_draft_that_is_known_and_goes_on():
    tab = PureTab()
    tab.take(WholeBody(True))
    known = plan_of(example_design(ROBOTS["anymal"]).jump)
    tab.take(TabOpened(plan=known))
    assert tab.told[0] is Verdict.DRAFT
    assert tab.submits[-1].task.plan is known
    finish(tab)
    assert tab.told[0] is Verdict.FEASIBLE


def test_the_nearest_jump_becomes_the_whole_bodys_too():
    tab = refining()
    finish(tab)
    tab.move(forward=0.3)
    asked = tab.submits[-1].task
    nearest = plan_of(replace(asked.jump, forward=0.2))
    failed = plan_of(asked.jump, "not-converged")
    tab.report(Refused(0, asked.jump, "its knees", failed, nearest))
    assert tab.told == (Verdict.NEAREST, "(the whole body's plan follows) ...")
    tab.wait()  # until the slider rests
    assert tab.submits[-1].task.wanted == asked.jump
    finish(tab)
    assert tab.state.plan.certified
    assert tab.told == (Verdict.NEAREST, "")
    assert tab.state.status.points == ("Forward 0.2 m instead of 0.3 m.", "Its knees.")
    assert tab.state.shown.remark == "Nearest: forward 0.2 m instead of 0.3 m"


def test_the_word_is_not_that_of_an_older_motion():
    tab = refining()
    finish(tab)
    tab.move(forward=0.05)
    assert tab.told[0] is Verdict.PLANNING
    tab.finish_plan()
    assert tab.told[0] is Verdict.DRAFT


@pytest.mark.parametrize("event", [Act.CANCEL, WholeBody(False)])
def test_given_up_the_first_plan_stays(event):
    tab = refining()
    plan = tab.state.plan
    tab.take(event)
    if event is Act.CANCEL:
        tab.report(Cancelled(0))
    else:
        finish(tab)
    assert tab.state.plan is plan
    assert not tab.state.status.busy
    assert not tab.state.planning


def test_while_a_slider_moves_nothing_is_refined():
    tab = refining()
    finish(tab)
    tab.move(forward=0.05)
    tab.finish_plan()
    assert tab.state.work.dragging.rests
    assert isinstance(tab.submits[-1].task, PlanJump)


def test_what_is_far_from_the_plan_that_is_shown_is_sought_by_the_whole_body_at_once():
    tab = refining(twist=0.5)
    finish(tab)
    tab.move(twist=2.0)
    assert tab.task.whole_body
    tab.wait()  # whatever rests until then
    draft = plan_of(tab.submits[-1].task.jump)
    tab.report(Planned(tab.submits[-1].ticket, refined_plan(draft)))
    assert tab.told == (Verdict.FEASIBLE, "")
    assert not tab.state.planning
    assert tab.kept() == [tab.state.design]
    assert tab.of(Submit) == []
    tab.wait()  # its draft, for the next steps
    assert (tab.task.alone, tab.task.whole_body) == (True, False)
    tab.report(Planned(0, draft))
    tab.move(twist=2.1)
    assert (tab.task.near, tab.task.whole_body) == (draft, False)


def test_where_it_is_a_draft_yet_that_is_followed():
    tab = refining(twist=0.5)
    finish(tab)
    tab.move(twist=2.0)
    tab.finish_plan()
    assert tab.state.work.dragging.rests
    with learned_of(tab.state.robot):
        tab.wait()
    assert isinstance(tab.submits[-1].task, RefinePlan)


@pytest.mark.parametrize("event", [WholeBody(True), Act.ROBOT_SIMULATOR])
def test_another_robot_that_is_being_prepared_is_not_forgotten(event):
    """What is shown is of the robot before, and about to go."""
    tab = planned_tab()
    tab.move(robot="go2")
    awaited = tab.state.work.awaited
    tab.take(event)
    assert tab.state.work.awaited is awaited
    assert tab.of(Submit) == []


def test_where_the_whole_body_does_less_that_is_the_nearest_to_what_was_asked():
    tab = refining()
    task = tab.submits[-1].task
    assert task.wanted == task.plan.jump
    less = replace(task.plan.jump, twist=task.plan.jump.twist / 2)
    plan = refined_plan(replace(task.plan, jump=less))
    refused = Refused(0, task.wanted, "LF_KFE is at its limit of 13.5 rad/s", plan, plan)
    tab.report(refused)
    assert tab.told[0] is Verdict.NEAREST
    assert tab.state.shown.wanted == task.plan.jump
    first, reason = tab.state.status.points
    assert "instead of" in first
    assert reason.startswith("LF_KFE is at its limit")
    tab.take(WholeBody(False))  # the draft does all of it
    assert tab.state.shown.wanted is None
    assert tab.told[0] is Verdict.DRAFT
    tab.take(WholeBody(True))
    tab.report(refused)
    tab.take(Act.NEAREST)
    assert tab.state.design.jump == less
    assert tab.told[0] is Verdict.FEASIBLE
