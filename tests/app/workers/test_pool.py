"""The pool of computing processes: order, cancelling, crashes. How tabs share: see test_sharing."""

from __future__ import annotations

import contextlib
import os
import queue
import signal
import time

import pytest

from app.workers.pool import WorkerPool
from app.workers.protocol import (
    Cancelled,
    Failed,
    PlanJump,
    Planned,
    Prepare,
    Prepared,
    Progress,
    Simulated,
)
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from tests.app import planners
from tests.app.planners import SyntheticPlanner, broken_factory
from tests.app.pool_tab import Tab


@pytest.fixture(scope="module")
def shared_pool():
    """With one process, so that there is one order."""
    pool = WorkerPool(SyntheticPlanner, processes=1)
    yield pool
    pool.close()


@pytest.fixture
def own_pool():
    pool = WorkerPool(SyntheticPlanner, processes=1, superseded_grace=0.2)
    yield pool
    pool.close()


def test_a_plan_comes_back_with_its_number_and_its_request(shared_pool):
    tab = Tab(shared_pool)
    job = tab.plan(forward=0.3)
    report = tab.outcome()
    assert isinstance(report, Planned)
    assert report.job == job
    assert report.plan.jump.forward == 0.3
    assert report.plan.com.shape == (49, 3)


def test_progress_comes_before_the_outcome(shared_pool):
    tab = Tab(shared_pool)
    job = shared_pool.submit("tab", Prepare("anymal"), tab.reports.put)
    assert tab.reports.get(timeout=20) == Progress(job, "preparing anymal")
    assert tab.reports.get(timeout=20) == Prepared(job, "anymal")


def test_who_waits_hears_what_for(shared_pool):
    first, second = Tab(shared_pool, "first"), Tab(shared_pool, "second")
    first.wait_until_running(first.plan(planners.SLOW))
    asked = time.monotonic()
    job = second.plan()
    assert second.reports.get(timeout=5) == Progress(job, "waiting: solving", waiting=True)
    assert 0.4 < time.monotonic() - asked < 0.9
    assert isinstance(second.outcome(), Planned)


def test_a_short_wait_is_not_worth_a_word(shared_pool):
    first, second = Tab(shared_pool, "first"), Tab(shared_pool, "second")
    first.plan()
    job = second.plan()
    second.wait_until_running(job)


@pytest.mark.parametrize(
    ("task", "message", "with_plan"),
    [
        (PlanJump(Jump(twist=planners.REFUSED)), "twist: expected -1 to 1 rad, got more", False),
        (
            PlanJump(Jump(twist=planners.UNSOLVABLE)),
            "no convergence: reach violated in flight by 0.02 m",
            True,
        ),
        (Prepare("nosuch"), 'no robot "nosuch"', False),
    ],
)
def test_a_users_error_is_a_message_and_the_process_lives_on(shared_pool, task, message, with_plan):
    tab = Tab(shared_pool)
    before = shared_pool.process_ids
    shared_pool.submit("tab", task, tab.reports.put)
    report = tab.outcome()
    assert isinstance(report, Failed)
    assert report.message == message
    assert (report.plan is not None) == with_plan
    assert shared_pool.process_ids == before


def test_the_newest_waiting_request_wins(shared_pool):
    busy, tab = Tab(shared_pool, "busy"), Tab(shared_pool, "tab")
    busy.wait_until_running(busy.plan(planners.SLOW))
    for i in range(20):
        last = tab.plan(forward=i / 100)
    report = tab.outcome()
    assert (report.job, report.plan.jump.forward) == (last, 0.19)
    time.sleep(0.1)
    assert tab.reports.empty()


def test_tabs_take_turns(shared_pool):
    """A tab that asks all the time does not keep another waiting."""
    order = queue.SimpleQueue()
    busy = Tab(shared_pool, "busy")
    busy.wait_until_running(busy.plan(planners.SLOW))

    def listen(name):
        return lambda report: None if isinstance(report, Progress) else order.put(name)

    jump = PlanJump(Jump())
    for tab in ("first", "second", "third"):
        shared_pool.submit(tab, jump, listen(tab))
    for _ in range(5):
        shared_pool.submit("first", jump, listen("first"))
        shared_pool.submit("third", jump, listen("third"))
    assert [order.get(timeout=20) for _ in range(3)] == ["first", "second", "third"]


def test_iteration_and_residual_are_told_ten_times_a_second(shared_pool):
    tab = Tab(shared_pool)
    job = tab.plan(planners.ITERATING)
    heard = []
    while not isinstance(report := tab.reports.get(timeout=20), Planned):
        assert (report.job, report.text) == (job, "solving")
        heard.append((time.monotonic(), report))
    lasted = heard[-1][0] - heard[0][0]
    assert 5 <= len(heard) <= 10 * lasted + 2
    for _, report in heard[1:]:
        assert report.residual == 10.0**-report.iteration
    assert heard[-1][1].iteration > 60


def test_cancel_is_heard_at_once_and_a_planner_that_asks_keeps_its_process(own_pool):
    tab = Tab(own_pool)
    job = tab.plan(planners.SLOW)
    tab.wait_until_running(job)
    process = own_pool.process_ids[0]
    began = time.monotonic()
    own_pool.cancel("tab")
    assert tab.outcome() == Cancelled(job)
    assert time.monotonic() - began < 0.1
    tab.plan()
    assert isinstance(tab.outcome(), Planned)
    assert own_pool.process_ids[0] == process


def test_a_job_that_does_not_stop_is_ended_with_its_process(own_pool):
    tab = Tab(own_pool)
    job = tab.plan(planners.STUBBORN)
    tab.wait_until_running(job)
    process = own_pool.process_ids[0]
    own_pool.cancel("tab")
    assert tab.outcome() == Cancelled(job)
    tab.plan()
    assert isinstance(tab.outcome(), Planned)
    assert own_pool.process_ids[0] != process
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)


def test_cancelling_reaches_waiting_jobs_and_no_other_tab(own_pool):
    busy, tab = Tab(own_pool, "busy"), Tab(own_pool, "tab")
    busy.wait_until_running(busy.plan(planners.SLOW))
    job = tab.plan()
    own_pool.cancel("tab")
    assert tab.outcome(timeout=0.5) == Cancelled(job)
    assert isinstance(busy.outcome(), Planned)


def test_cancelling_nothing_is_silent(shared_pool):
    tab = Tab(shared_pool)
    tab.plan()
    shared_pool.cancel("tab of nobody")
    assert isinstance(tab.outcome(), Planned)


def test_a_long_job_makes_way_for_its_tabs_newer_request(own_pool):
    tab = Tab(own_pool)
    old = tab.plan(planners.SLOW)
    tab.wait_until_running(old)
    new = tab.plan()
    assert tab.outcome() == Cancelled(old)
    report = tab.outcome()
    assert (type(report), report.job) == (Planned, new)


def test_a_rollout_comes_back_with_its_number_and_its_scenario(shared_pool):
    tab = Tab(shared_pool)
    job = tab.simulate(board=0.02, seed=3)
    report = tab.outcome()
    assert isinstance(report, Simulated)
    assert report.job == job
    assert report.rollout.scenario == Scenario(board=0.02, seed=3)
    assert report.rollout.landed


def test_a_simulation_tells_per_cents_to_its_tab_and_words_to_others(own_pool):
    tab, other = Tab(own_pool), Tab(own_pool, "other")
    job = tab.simulate(seed=planners.SLOWLY)
    tab.wait_until_running(job)
    other.plan()
    shares = [tab.progress().share for _ in range(8)]
    assert shares == sorted(set(shares))
    assert 0.05 < shares[-1] < 0.3
    own_pool.cancel("tab")
    told = other.reports.get(timeout=20)
    assert told.text.startswith("waiting: simulating, ")
    # Whose per cents they are would be misunderstood as its own.
    assert told.share is None
    assert isinstance(other.outcome(), Planned)


def test_a_simulation_makes_way_at_once(own_pool):
    tab = Tab(own_pool)
    old = tab.simulate(seed=planners.SLOWLY)
    tab.wait_until_running(old)
    began = time.monotonic()
    new = tab.plan()
    assert tab.outcome() == Cancelled(old)
    assert time.monotonic() - began < 0.5
    assert tab.outcome().job == new


@pytest.mark.parametrize("way", [planners.CRASH, planners.DEFECT])
def test_a_crash_is_told_and_the_process_restarted(own_pool, way):
    tab, other = Tab(own_pool), Tab(own_pool, "other")
    job = tab.plan(way)
    other_job = other.plan()
    report = tab.outcome()
    status = 9 if way == planners.CRASH else 1
    assert report == Failed(
        job, f"The computing process ended unexpectedly (exit status {status}) and was restarted."
    )
    assert other.outcome().job == other_job
    tab.plan()
    assert isinstance(tab.outcome(), Planned)


def test_a_defect_leaves_its_traceback_in_the_terminal(capfd):
    # Made here: between a test's set-up and its call, pytest shows no process where to write.
    with contextlib.closing(WorkerPool(SyntheticPlanner)) as pool:
        tab = Tab(pool)
        tab.plan(planners.DEFECT)
        assert "exit status 1" in tab.outcome().message
    assert "ZeroDivisionError: a defect" in capfd.readouterr().err


def test_a_process_killed_from_outside_is_replaced(own_pool):
    tab = Tab(own_pool)
    tab.wait_until_running(tab.plan(planners.SLOW))
    os.kill(own_pool.process_ids[0], signal.SIGKILL)
    assert "signal 9" in tab.outcome().message
    tab.plan()
    assert isinstance(tab.outcome(), Planned)


def test_a_process_that_cannot_start_is_told_and_does_not_spin(capfd):
    pool = WorkerPool(broken_factory, processes=1)
    try:
        tab = Tab(pool)
        for _ in range(2):
            tab.plan()
            assert "does not start (exit status 1)" in tab.outcome().message
        time.sleep(0.3)
        assert pool.process_ids == (None,)
    finally:
        pool.close()
    assert capfd.readouterr().err.count("ModuleNotFoundError: no planner here") <= 3


def test_closing_ends_the_process_even_in_the_middle_of_a_job():
    pool = WorkerPool(SyntheticPlanner, processes=1)
    tab = Tab(pool)
    tab.wait_until_running(tab.plan(planners.STUBBORN))
    process = pool.process_ids[0]
    pool.close()
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)


def test_a_tab_that_has_gone_hears_nothing(own_pool):
    tab = Tab(own_pool)
    tab.wait_until_running(tab.plan(planners.SLOW))
    own_pool.forget("tab")
    other = Tab(own_pool, "other")
    other.plan()
    assert isinstance(other.outcome(), Planned)
    assert tab.reports.empty()
