"""Several seeds of one plan: every one reported, the worst kept."""

import math
from contextlib import closing
from dataclasses import replace

import pytest

from app.workers.pool import WorkerPool
from app.workers.reports import (
    Cancelled,
    Failed,
    Partial,
    Planned,
    Progress,
    SeedDone,
    Simulated,
    SimulatedSeeds,
    SimulatedSoFar,
)
from app.workers.seeds import MOST_SEEDS, Seeds, badness, result_of
from app.workers.tasks import SimulateSeeds
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


def reports_on(rollouts):
    """What becomes of a job of these seeds, simulated in this order."""
    collected = Seeds(7, SimulateSeeds(PLAN, SCENARIO, tuple(sorted(rollouts))))
    parts = {p.scenario.seed: p for p in SimulateSeeds(PLAN, SCENARIO, tuple(rollouts)).parts}
    found = []
    for seed, made in rollouts.items():
        made = replace(made, scenario=SCENARIO.but(seed=seed))
        found += collected.take(parts[seed], Simulated(7, made))
    return found


def test_every_seed_is_reported_and_the_outcome_is_in_their_order():
    *done, outcome = reports_on({3: rollout(), 1: rollout(1.1), 2: rollout()})
    assert [report.result.seed for report in done] == [3, 1, 2]
    assert [(report.done, report.of) for report in done] == [(1, 3), (2, 3), (3, 3)]
    assert [result.seed for result in outcome.results] == [1, 2, 3]
    assert [result.landed for result in outcome.results] == [False, True, True]


def test_progress_is_the_share_of_all_and_a_failure_ends_it():
    task = SimulateSeeds(PLAN, SCENARIO, (1, 2))
    collected = Seeds(7, task)
    (report,) = collected.take(task.parts[0], Progress(7, "simulating, 50 %", share=0.5))
    assert report == Progress(7, "simulating, 0 of 2 seeds done", share=0.25)
    assert collected.take(task.parts[1], Failed(7, "no")) == [Failed(7, "no")]


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
    for order in (1, -1):  # in which processes come back
        kept = reports_on(dict([*enumerate(rollouts)][::order]))[-1].worst
        assert kept.scenario.seed == worst
        assert badness(kept) == max(map(badness, rollouts))


@pytest.mark.parametrize("seeds", [(), (1, 2, 1), tuple(range(MOST_SEEDS + 1))])
def test_no_seed_too_many_or_one_twice_is_a_mistake(seeds):
    with pytest.raises(InputError, match=f"seeds: expected 1 to {MOST_SEEDS} different ones"):
        Seeds(7, SimulateSeeds(PLAN, SCENARIO, seeds))


@pytest.fixture(scope="module")
def pool():
    made = WorkerPool(SyntheticPlanner, processes=2)
    yield made
    made.close()


def reports_until_the_outcome(tab):
    reports = []
    while isinstance(report := tab.reports.get(timeout=60), Partial):
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
    job = tab.submit(SimulateSeeds(PLAN, Scenario(), (1, planners.SLOWLY, 2)))
    while not isinstance(tab.reports.get(timeout=60), SeedDone):
        pass
    other.plan()
    assert isinstance(other.outcome(timeout=60), Planned)  # its process may still be starting
    before = pool.process_ids
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
        report = tab.reports.get(timeout=60)
        assert isinstance(report, Progress | SimulatedSoFar)
        if isinstance(report, SimulatedSoFar):
            motions.append(report)
    pool.cancel("tab")
    assert [motion.job for motion in motions] == [job] * 3
    assert [len(motion.time) for motion in motions] == [1, 2, 3]
    assert [motion.share for motion in motions] == sorted(motion.share for motion in motions)
    assert motions[-1].qpos.shape == (3, 19)


def test_a_newer_request_ends_all_seeds_with_one_report():
    with closing(WorkerPool(SyntheticPlanner, processes=3)) as pool:
        tab, other = Tab(pool), Tab(pool, "other")
        old = tab.submit(SimulateSeeds(PLAN, Scenario(), (planners.SLOWLY, 1, 2, 3, 4)))
        while not isinstance(tab.reports.get(timeout=60), SeedDone):
            pass
        new = tab.submit(SimulateSeeds(PLAN, Scenario(), (1, 2)))
        outcomes = [tab.outcome(), tab.outcome()]
        assert outcomes[0] == Cancelled(old)
        assert outcomes[1].job == new
        other.simulate(seed=1)
        assert other.outcome().rollout.landed
        assert tab.reports.empty()


def test_a_seed_that_cannot_be_simulated_fails_them_all_once():
    with closing(WorkerPool(SyntheticPlanner, processes=3)) as pool:
        tab = Tab(pool)
        job = tab.submit(SimulateSeeds(PLAN, Scenario(), (1, planners.IMPOSSIBLE, planners.SLOWLY)))
        assert reports_until_the_outcome(tab)[1] == Failed(
            job, "board: expected 0 to 0.05 m, got more"
        )
        tab.simulate(seed=1)
        assert tab.outcome(timeout=5).rollout.landed


def test_results_say_in_words_how_it_went():
    assert result_of(1, rollout(foot_error=0.0123)).line == (
        "Landed; feet within 12 mm of the plan."
    )
    assert result_of(1, rollout(foot_error=0.08, strict=False)).line == (
        "Landed, not strict: feet misplaced by 80 mm."
    )
    fallen = result_of(7, rollout(1.1))
    assert fallen.line.startswith("Fell at 1.10 s: ")
    assert (fallen.seed, fallen.landed, fallen.fell_at_s) == (7, False, 1.1)
