"""A way to make a jump: planned, with patience where that needs it, and followed."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from app.workers.reports import Planned, Progress, Refused, Simulated, SimulatedSoFar, Talk
from app.workers.tasks import FollowWay, LoadSolver, PlanJump, PlanWay, solver_of
from app.workers.worker import LibraryPlanner
from llsrbm.errors import NotConverged
from llsrbm.ocp.solvers.fatrop import Fatrop
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning
from tests.app.pure_tab import plan_of, rollout_of

JUMP, TUNING, SCENARIO = Jump(twist=0.5), Tuning(limits={"friction": 0.4}), Scenario(board=0.02)


class Planner:
    """`fails`: how many of its first plans do."""

    def __init__(self, fails=0):
        self.fails, self.asked, self.followed, self.refined = fails, [], [], []

    def plan(self, task, progress, cancelled):
        self.asked.append(task)
        if len(self.asked) <= self.fails:
            raise NotConverged("no", plan_of(task.jump, "not-converged"), reason="the knees")
        return plan_of(task.jump)

    def refine(self, task, progress, cancelled):
        self.refined.append((task.plan.jump, task.wanted))
        return task.plan

    def simulate(self, task, progress, so_far, cancelled):
        self.followed.append((task.plan, task.scenario))
        progress("simulating, 1 %", share=0.01)
        so_far(0.1, [0.0], [[0.0]])
        return rollout_of(task.plan)


@pytest.fixture
def sent():
    return []


@pytest.fixture
def talk(sent):
    return Talk(7, sent.append, SimpleNamespace(value=0))


def test_it_is_followed_and_its_beginning_is_not_sent(talk, sent):
    planner, plan = Planner(), plan_of(JUMP)
    task = FollowWay(plan, SCENARIO)
    assert isinstance(task.work(planner, talk), Simulated)
    assert planner.followed == [(plan, SCENARIO)]
    assert task.kind.long
    assert task.needs is None
    assert any(isinstance(each, Progress) for each in sent)
    assert not any(isinstance(each, SimulatedSoFar) for each in sent)


def test_it_is_planned_quickly_where_that_does(talk):
    planner, task = Planner(), PlanWay(JUMP, TUNING)
    assert isinstance(task.work(planner, talk), Planned)
    asked = [(each.jump, each.tuning, each.alone) for each in planner.asked]
    assert asked == [(JUMP, TUNING, True)]
    assert not task.kind.long  # it may go to the process that keeps away from what lasts
    assert task.needs == solver_of(JUMP, TUNING)


def test_what_fails_at_first_is_planned_with_patience(talk):
    planner = Planner(fails=1)
    assert isinstance(PlanWay(JUMP, TUNING).work(planner, talk), Planned)
    assert [each.alone for each in planner.asked] == [True, False]
    refused = PlanWay(JUMP, TUNING).work(Planner(fails=2), talk)
    assert isinstance(refused, Refused)
    assert refused.reason == "the knees"


@pytest.mark.parametrize("fails", [0, 1])
def test_a_solver_that_is_loaded_has_followed_a_plan_too(talk, fails):
    planner, task = Planner(fails), LoadSolver(JUMP, TUNING)
    assert isinstance(task.work(planner, talk), Refused if fails else Planned)
    near = [each.near and each.near.jump for each in planner.asked]
    assert near == ([None] if fails else [None, JUMP])
    assert {(each.jump, each.tuning) for each in planner.asked} == {(JUMP, TUNING)}
    assert planner.refined == ([] if fails else [(JUMP, JUMP)])


def test_the_first_step_of_a_slider_makes_no_solver(talk, monkeypatch):
    made = []
    take = Fatrop._nlpsol
    monkeypatch.setattr(Fatrop, "_nlpsol", lambda *each: made.append(1) or take(*each))
    planner = LibraryPlanner()
    found = LoadSolver(Jump(robot="go2", model="srbm", twist=0.2)).work(planner, talk)
    assert made.pop()
    made.clear()
    step = replace(found.plan.jump, twist=0.25)
    assert isinstance(PlanJump(step, near=found.plan, alone=True).work(planner, talk), Planned)
    assert not made
