"""A way to make a jump: planned unless it is, with patience where that needs it, and followed."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from app.workers.reports import Progress, Refused, Simulated, SimulatedSoFar, Talk
from app.workers.tasks import TryWay, solver_of
from llsrbm.errors import NotConverged
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning
from tests.app.pure_tab import plan_of, rollout_of

JUMP, TUNING, SCENARIO = Jump(twist=0.5), Tuning(limits={"friction": 0.4}), Scenario(board=0.02)


class Planner:
    """`fails`: how many of its first plans do."""

    def __init__(self, fails=0):
        self.fails, self.asked, self.followed = fails, [], []

    def plan(self, task, progress, cancelled):
        self.asked.append(task)
        if len(self.asked) <= self.fails:
            raise NotConverged("no", plan_of(task.jump, "not-converged"), reason="the knees")
        return plan_of(task.jump)

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


def test_it_is_planned_and_followed_and_its_beginning_is_not_sent(talk, sent):
    planner, task = Planner(), TryWay(JUMP, TUNING, SCENARIO)
    report = task.work(planner, talk)
    assert isinstance(report, Simulated)
    assert [(each.jump, each.tuning, each.alone) for each in planner.asked] == [
        (JUMP, TUNING, True)
    ]
    assert planner.followed == [(plan_of(JUMP), SCENARIO)]
    assert task.needs == solver_of(JUMP)
    assert any(isinstance(each, Progress) for each in sent)
    assert not any(isinstance(each, SimulatedSoFar) for each in sent)


def test_what_fails_at_first_is_tried_with_patience(talk):
    planner = Planner(fails=1)
    assert isinstance(TryWay(JUMP, TUNING, SCENARIO).work(planner, talk), Simulated)
    assert [each.alone for each in planner.asked] == [True, False]
    refused = TryWay(JUMP, TUNING, SCENARIO).work(Planner(fails=2), talk)
    assert isinstance(refused, Refused)
    assert refused.reason == "the knees"


def test_a_plan_that_is_there_needs_no_solver(talk):
    planner, task = Planner(), TryWay(JUMP, TUNING, SCENARIO, plan_of(JUMP))
    assert isinstance(task.work(planner, talk), Simulated)
    assert planner.asked == []
    assert task.needs is None
