"""Whole body: plans are refined once they have rested, and go back to what they were."""

import pytest

from app.panel.acts import Act
from app.panel.status import Verdict
from app.tab.effects import After, Submit
from app.tab.planning.refining import WholeBody
from app.tab.simulating import Automatically
from app.workers.reports import Cancelled, Planned
from app.workers.tasks import PlanJump, RefinePlan, SimulateJump
from tests.app.pure_tab import planned_tab
from tests.app.synthetic_plan import refined_plan


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
    assert tab.state.status.busy
    finish(tab)
    assert tab.state.plan.refined
    assert tab.told == (Verdict.FEASIBLE, "whole body")
    assert not tab.state.status.busy
    asked = len(tab.submits)
    tab.take(WholeBody(False))
    assert tab.state.plan is centroidal
    assert tab.told == (Verdict.FEASIBLE, "")
    assert len(tab.submits) == asked


def test_a_plan_is_refined_when_its_request_has_rested_and_then_simulated():
    tab = refining()
    finish(tab)
    tab.take(Automatically(True))
    tab.finish_simulation()
    tab.move(forward=0.1)
    tab.finish_plan()  # the quick one
    (rested,) = tab.of(After)
    tab.take(rested.event)
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
    assert tab.told == (Verdict.FEASIBLE, "not refined: the whole body's plan was not found")


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


@pytest.mark.parametrize("event", [WholeBody(True), Act.ROBOT_SIMULATOR])
def test_another_robot_that_is_being_prepared_is_not_forgotten(event):
    """What is shown is of the robot before, and about to go."""
    tab = planned_tab()
    tab.move(robot="go2")
    awaited = tab.state.work.awaited
    tab.take(event)
    assert tab.state.work.awaited is awaited
    assert tab.of(Submit) == []
