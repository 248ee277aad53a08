from __future__ import annotations

from dataclasses import replace

import pytest

from app.tab.drag_planning import DragPlanning
from app.workers.protocol import PlanJump
from llsrbm.request.jump import Jump
from llsrbm.request.tuning import Tuning
from tests.app.synthetic_plan import synthetic_plan

JUMP = Jump(robot="anymal", twist=1.0)
NEXT = replace(JUMP, twist=1.1)
PLAIN = Tuning()
NEW = DragPlanning()


@pytest.fixture(scope="module")
def shown():
    """With the solver's solution, of which only its being there matters here."""
    return replace(synthetic_plan(JUMP), solution=object())


@pytest.fixture(scope="module")
def resting(shown):
    """A request that has its quick answer."""
    moved, task = NEW.request(NEXT, PLAIN, shown)
    return moved.answered(task)


def test_the_first_plan_is_sought_patiently():
    dragging, task = NEW.request(JUMP, PLAIN, None)
    assert task == PlanJump(JUMP, PLAIN)
    assert not dragging.rests


def test_the_same_request_is_planned_once(shown):
    dragging, _ = NEW.request(JUMP, PLAIN, None)
    assert dragging.request(JUMP, PLAIN, shown) == (dragging, None)
    assert dragging.request(JUMP, Tuning(weights={"force": 2.0}), shown)[1] is not None


def test_a_change_starts_from_what_is_shown(shown):
    _, task = NEW.request(NEXT, PLAIN, shown)
    assert (task.jump, task.near, task.patient) == (NEXT, shown, False)


@pytest.mark.parametrize(
    "change", [{"twist": 1.6}, {"twist": 0.4}, {"forward": 0.2}, {"lateral": -0.2}, {"height": 0.2}]
)
def test_from_far_away_it_is_quicker_to_start_anew(shown, change):
    _, task = NEW.request(replace(JUMP, **change), PLAIN, shown)
    assert (task.near, task.patient) == (None, False)


def test_a_plan_from_a_file_has_no_solution_to_start_from():
    _, task = NEW.request(NEXT, PLAIN, synthetic_plan(JUMP))
    assert (task.near, task.patient) == (None, False)


@pytest.mark.parametrize("change", [{"robot": "go2"}, {"model": "srbm"}])
def test_another_robots_or_models_plan_is_no_start(shown, change):
    _, task = NEW.request(replace(NEXT, **change), PLAIN, shown)
    assert (task.near, task.patient) == (None, True)


def test_what_did_not_converge_is_no_start():
    _, task = NEW.request(NEXT, PLAIN, synthetic_plan(JUMP, "not-converged"))
    assert (task.near, task.patient) == (None, True)


def test_after_a_rest_the_request_is_planned_from_scratch(resting):
    assert resting.rests
    done, task = resting.rested(resting.rest)
    assert task == PlanJump(NEXT, PLAIN)
    assert not done.rests
    assert done.rested(done.rest) == (done, None)
    assert done.answered(task) is done


def test_a_patient_answer_is_the_last():
    dragging, task = NEW.request(JUMP, PLAIN, None)
    assert dragging.answered(task) is dragging
    assert not dragging.rests


def test_a_newer_request_ends_the_rest(resting, shown):
    third = replace(JUMP, twist=1.2)
    dragging, task = resting.request(third, PLAIN, shown)
    assert task.jump == third
    assert dragging.rested(resting.rest) == (dragging, None)
    dragging = dragging.answered(task)
    assert dragging.rested(resting.rest) == (dragging, None)  # of the rest before
    assert dragging.rested(dragging.rest)[1] == PlanJump(third, PLAIN)


def test_what_is_forgotten_is_not_planned_and_counts_as_new(resting, shown):
    dragging = resting.forget()
    assert not dragging.rests
    assert dragging.rested(resting.rest) == (dragging, None)
    assert dragging.request(NEXT, PLAIN, shown)[1] is not None
