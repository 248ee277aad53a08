from __future__ import annotations

from dataclasses import replace

import pytest

from app.compute.protocol import PlanJump
from app.session.drag_planning import REST, DragPlanning
from llsrbm.jump import Jump
from llsrbm.tuning import Tuning
from tests.app.synthetic_plan import synthetic_plan

JUMP = Jump(robot="anymal", twist=1.0)
NEXT = replace(JUMP, twist=1.1)
PLAIN = Tuning()


class Clock:
    now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def live(clock):
    return DragPlanning(clock)


@pytest.fixture(scope="module")
def shown():
    """With the solver's solution, of which only its being there matters here."""
    return replace(synthetic_plan(JUMP), solution=object())


def test_the_first_plan_is_sought_patiently(live):
    assert live.ask(JUMP, PLAIN, None) == PlanJump(JUMP, PLAIN)
    assert live.settled


def test_the_same_request_is_asked_for_once(live, shown):
    live.ask(JUMP, PLAIN, None)
    assert live.ask(JUMP, PLAIN, shown) is None
    assert live.ask(JUMP, Tuning(weights={"force": 2.0}), shown) is not None


def test_a_change_starts_from_what_is_shown(live, shown):
    task = live.ask(NEXT, PLAIN, shown)
    assert (task.jump, task.near, task.patient) == (NEXT, shown, False)


@pytest.mark.parametrize(
    "change", [{"twist": 1.6}, {"twist": 0.4}, {"forward": 0.2}, {"lateral": -0.2}, {"height": 0.2}]
)
def test_from_far_away_it_is_quicker_to_start_anew(live, shown, change):
    task = live.ask(replace(JUMP, **change), PLAIN, shown)
    assert (task.near, task.patient) == (None, False)


def test_a_plan_from_a_file_has_no_solution_to_start_from(live):
    task = live.ask(NEXT, PLAIN, synthetic_plan(JUMP))
    assert (task.near, task.patient) == (None, False)


@pytest.mark.parametrize("change", [{"robot": "go2"}, {"model": "srbm"}])
def test_another_robots_or_models_plan_is_no_start(live, shown, change):
    task = live.ask(replace(NEXT, **change), PLAIN, shown)
    assert (task.near, task.patient) == (None, True)


def test_what_did_not_converge_is_no_start(live):
    task = live.ask(NEXT, PLAIN, synthetic_plan(JUMP, "not-converged"))
    assert (task.near, task.patient) == (None, True)


def test_after_a_rest_the_request_is_planned_from_scratch(live, clock, shown):
    live.answered(live.ask(NEXT, PLAIN, shown))
    assert not live.settled
    assert live.wait == pytest.approx(REST)
    assert live.due() is None
    clock.now += 0.9 * REST
    assert live.due() is None
    clock.now += 0.2 * REST
    assert live.wait == 0
    assert live.due() == PlanJump(NEXT, PLAIN)
    assert live.settled
    assert live.due() is None
    assert live.wait is None


def test_a_patient_answer_is_the_last(live):
    live.answered(live.ask(JUMP, PLAIN, None))
    assert live.settled
    assert live.due() is None


def test_a_newer_request_ends_the_rest(live, clock, shown):
    live.answered(live.ask(NEXT, PLAIN, shown))
    third = replace(JUMP, twist=1.2)
    task = live.ask(third, PLAIN, shown)
    assert task.jump == third
    clock.now += 2 * REST
    assert live.due() is None
    live.answered(task)
    clock.now += 2 * REST
    assert live.due() == PlanJump(third, PLAIN)


def test_what_is_forgotten_is_not_planned_and_counts_as_new(live, clock, shown):
    live.answered(live.ask(NEXT, PLAIN, shown))
    live.forget()
    clock.now += 2 * REST
    assert (live.settled, live.wait, live.due()) == (True, None, None)
    assert live.ask(NEXT, PLAIN, shown) is not None
