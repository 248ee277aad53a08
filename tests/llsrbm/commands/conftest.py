"""A planner and a simulator that answer at once, for the commands that call them."""

from dataclasses import replace

import pytest

import llsrbm
from tests.llsrbm.synthetic import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    path = tmp_path_factory.mktemp("cli") / "plan.npz"
    synthetic_plan().save(path)
    return path


@pytest.fixture
def planner(monkeypatch):
    """`llsrbm.plan` that answers at once with the plan or the error put first into the list."""
    answers, requests = [synthetic_plan()], []

    def plan(jump, **options):
        requests.append((jump, options))
        print("a banner of a solver")
        if isinstance(answers[0], Exception):
            raise answers[0]
        return replace(answers[0], jump=jump)

    monkeypatch.setattr(llsrbm, "plan", plan)
    plan.answers, plan.requests = answers, requests
    return plan


@pytest.fixture
def simulator(monkeypatch):
    """`llsrbm.simulate` that answers at once with the rollout or the error put first."""
    answers, requests = [synthetic_rollout()], []

    def simulate(plan, scenario, *, progress):
        requests.append((plan, scenario))
        print("a banner of a simulator")
        progress(0.5)
        if isinstance(answers[0], Exception):
            raise answers[0]
        return answers[0]

    monkeypatch.setattr(llsrbm, "simulate", simulate)
    simulate.answers, simulate.requests = answers, requests
    return simulate
