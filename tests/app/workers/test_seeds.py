"""Several seeds of one plan: every one reported, the worst kept."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from app.workers.pool import WorkerPool
from app.workers.protocol import (
    Cancelled,
    Partial,
    Planned,
    Progress,
    SeedDone,
    SimulatedSeeds,
    SimulatedSoFar,
    SimulateSeeds,
)
from app.workers.seeds import MOST_SEEDS, badness, result_of, simulate_seeds
from llsrbm.errors import InputError
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from tests.app import planners
from tests.app.planners import SyntheticPlanner
from tests.app.pool_tab import Tab
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout

PLAN = synthetic_plan(Jump(twist=1.0))
SCENARIO = Scenario(board=0.02, noise=2.0)


def rollout(fell_at=None, foot_error=0.01, strict=True):
    made = synthetic_rollout(PLAN, fell_at=fell_at)
    return replace(made, outcome=replace(made.outcome, foot_error=foot_error, strict=strict))


class Given:
    """Simulates nothing: gives the rollouts that were made before, and keeps the scenarios."""

    def __init__(self, rollouts):
        self.rollouts, self.scenarios = rollouts, []

    def simulate(self, task, progress, so_far, cancelled):
        self.scenarios.append(task.scenario)
        progress("simulating, 50 %", share=0.5)
        return self.rollouts[task.scenario.seed]


def run(rollouts, seeds=None, cancelled=lambda: False):
    planner, shares, done = Given(rollouts), [], []
    results, worst = simulate_seeds(
        planner,
        SimulateSeeds(PLAN, SCENARIO, tuple(rollouts) if seeds is None else seeds),
        lambda text, *, share: shares.append((text, share)),
        lambda *one: done.append(one),
        cancelled,
    )
    return planner, shares, done, results, worst


def test_every_seed_is_simulated_in_the_same_scenario_and_reported():
    planner, shares, done, results, _ = run({3: rollout(), 1: rollout(1.1), 2: rollout()})
    assert planner.scenarios == [SCENARIO.but(seed=seed) for seed in (3, 1, 2)]
    assert [result.seed for result in results] == [3, 1, 2]
    assert [result.landed for result in results] == [True, False, True]
    assert done == [(result, number, 3) for number, result in enumerate(results, 1)]
    assert shares[1] == ("seed 2 of 3, simulating, 50 %", 0.5)


@pytest.mark.parametrize(
    ("rollouts", "worst"),
    [
        ((rollout(1.1), rollout(0.2), rollout(foot_error=9.0)), 1),  # the earliest fall
        ((rollout(foot_error=0.01), rollout(foot_error=0.04), rollout(foot_error=0.02)), 1),
        ((rollout(foot_error=0.04), rollout(foot_error=0.01, strict=False)), 0),
        ((rollout(), rollout()), 0),  # the first of equals
    ],
)
def test_the_worst_is_the_earliest_fall_else_the_feet_that_miss_by_most(rollouts, worst):
    kept = run(dict(enumerate(rollouts)))[4]
    assert kept is rollouts[worst]
    assert badness(kept) == max(map(badness, rollouts))


def test_results_say_in_words_how_it_went():
    assert result_of(1, rollout(foot_error=0.0123)).line == (
        "Landed; feet within 12 mm of the plan."
    )
    assert result_of(1, rollout(foot_error=0.08, strict=False)).line == (
        "Landed, but failed the strict criterion; feet within 80 mm of the plan."
    )
    fallen = result_of(7, rollout(1.1))
    assert fallen.line.startswith("Fell at 1.10 s: ")
    assert (fallen.seed, fallen.landed, fallen.fell_at_s) == (7, False, 1.1)


@pytest.mark.parametrize("seeds", [(), (1, 2, 1), tuple(range(MOST_SEEDS + 1))])
def test_no_seed_too_many_or_one_twice_is_a_mistake(seeds):
    with pytest.raises(InputError, match=f"seeds: expected 1 to {MOST_SEEDS} different ones"):
        run({}, seeds)


@pytest.fixture(scope="module")
def pool():
    made = WorkerPool(SyntheticPlanner, processes=2)
    yield made
    made.close()


def reports_until_the_outcome(tab):
    reports = []
    while isinstance(report := tab.reports.get(timeout=20), Partial):
        reports.append(report)
    return reports, report


def test_seeds_go_through_the_pool_and_the_worst_comes_back(pool):
    tab = Tab(pool)
    seeds = (1, planners.FALLING, planners.TRIPPING, 4)
    job = tab.submit(SimulateSeeds(PLAN, Scenario(), seeds))
    reports, outcome = reports_until_the_outcome(tab)
    assert isinstance(outcome, SimulatedSeeds)
    assert outcome.job == job
    done = [report for report in reports if isinstance(report, SeedDone)]
    assert tuple(report.result for report in done) == outcome.results
    assert [(report.done, report.of) for report in done] == [(n, 4) for n in range(1, 5)]
    assert [result.landed for result in outcome.results] == [True, False, False, True]
    assert outcome.worst.scenario.seed == planners.TRIPPING
    assert math.isclose(outcome.worst.outcome.fell_at_s, 0.2)


def test_seeds_are_cancelled_within_a_run_and_leave_room_for_plans(pool):
    tab, other = Tab(pool), Tab(pool, "other")
    before = pool.process_ids
    job = tab.submit(SimulateSeeds(PLAN, Scenario(), (1, planners.SLOWLY, 2)))
    while not isinstance(tab.reports.get(timeout=20), SeedDone):
        pass
    other.plan()
    assert isinstance(other.outcome(timeout=5), Planned)
    pool.cancel("tab")
    assert reports_until_the_outcome(tab)[1] == Cancelled(job)
    other.simulate(seed=1)
    assert other.outcome(timeout=5).rollout.landed
    assert pool.process_ids == before


def test_a_simulation_reports_its_motion_so_far(pool):
    tab = Tab(pool)
    job = tab.simulate(seed=planners.SLOWLY)
    motions = []
    while len(motions) < 3:
        report = tab.reports.get(timeout=20)
        assert isinstance(report, Progress | SimulatedSoFar)
        if isinstance(report, SimulatedSoFar):
            motions.append(report)
    pool.cancel("tab")
    assert [motion.job for motion in motions] == [job] * 3
    assert [len(motion.time) for motion in motions] == [1, 2, 3]
    assert [motion.share for motion in motions] == sorted(motion.share for motion in motions)
    assert motions[-1].qpos.shape == (3, 19)
