"""The pool of computing processes: order, cancelling, crashes. How tabs share: see test_sharing."""

import contextlib
import time

import pytest

from app.workers.pool import WorkerPool
from app.workers.reports import Cancelled, Failed, Planned, Prepared, Progress
from app.workers.tasks import PlanJump, Prepare
from llsrbm.request.jump import Jump
from tests.app import planners
from tests.app.planners import SyntheticPlanner, broken_factory
from tests.app.pool_tab import Tab


@pytest.fixture(scope="module")
def shared_pool():
    """With one process, so that there is one order."""
    with contextlib.closing(WorkerPool(SyntheticPlanner, processes=1)) as pool:
        yield pool


def test_progress_comes_before_the_outcome(shared_pool):
    tab = Tab(shared_pool)
    tab.plan()
    assert isinstance(tab.outcome(), Planned)  # its process has started
    job = shared_pool.submit("tab", Prepare("anymal"), tab.reports.put)
    assert tab.reports.get(timeout=60) == Progress(job, "preparing anymal")
    assert tab.reports.get(timeout=60) == Prepared(job, "anymal")


def test_who_waits_hears_what_for(shared_pool):
    first, second = Tab(shared_pool, "first"), Tab(shared_pool, "second")
    first.wait_until_running(first.plan(planners.SLOW))
    asked = time.monotonic()
    job = second.plan()
    assert second.reports.get(timeout=5) == Progress(job, "waiting: solving", waiting=True)
    assert time.monotonic() - asked > 0.4
    assert isinstance(second.outcome(), Planned)


@pytest.mark.parametrize(
    ("task", "message"),
    [
        (PlanJump(Jump(twist=planners.REFUSED)), "twist: expected -1 to 1 rad, got more"),
        (Prepare("nosuch"), 'no robot "nosuch"'),
    ],
)
def test_a_users_error_is_a_message_and_the_process_lives_on(shared_pool, task, message):
    tab = Tab(shared_pool)
    before = shared_pool.process_ids
    shared_pool.submit("tab", task, tab.reports.put)
    report = tab.outcome()
    assert isinstance(report, Failed)
    assert report.message == message
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


def test_iteration_and_residual_are_told_ten_times_a_second(shared_pool):
    tab = Tab(shared_pool)
    job = tab.plan(planners.ITERATING)
    heard = []
    while not isinstance(report := tab.reports.get(timeout=60), Planned):
        assert (report.job, report.text) == (job, "solving")
        heard.append((time.monotonic(), report))
    lasted = heard[-1][0] - heard[0][0]
    assert 5 <= len(heard) <= 10 * lasted + 2
    for _, report in heard[1:]:
        assert report.residual == 10.0**-report.iteration
    assert heard[-1][1].iteration > 60


def test_cancel_is_heard_at_once_and_a_planner_that_asks_keeps_its_process(shared_pool):
    tab = Tab(shared_pool)
    job = tab.plan(planners.SLOW)
    tab.wait_until_running(job)
    process = shared_pool.process_ids[0]
    began = time.monotonic()
    shared_pool.cancel("tab")
    assert tab.outcome() == Cancelled(job)
    assert time.monotonic() - began < 0.5  # of a second
    tab.plan()
    assert isinstance(tab.outcome(), Planned)
    assert shared_pool.process_ids[0] == process


def test_cancelling_reaches_waiting_jobs_and_no_other_tab(shared_pool):
    busy, tab = Tab(shared_pool, "busy"), Tab(shared_pool, "tab")
    busy.wait_until_running(busy.plan(planners.SLOW))
    job = tab.plan()
    shared_pool.cancel("tab")
    assert tab.outcome(timeout=0.5) == Cancelled(job)
    assert isinstance(busy.outcome(), Planned)


def test_a_simulation_tells_per_cents_to_its_tab_and_words_to_others(shared_pool):
    tab, other = Tab(shared_pool), Tab(shared_pool, "other")
    job = tab.simulate(seed=planners.SLOWLY)
    tab.wait_until_running(job)
    other.plan()
    shares = [tab.progress().share for _ in range(8)]
    assert shares == sorted(set(shares))
    assert 0.05 < shares[-1] < 0.3
    shared_pool.cancel("tab")
    told = other.reports.get(timeout=60)
    assert told.text.startswith("waiting: simulating, ")
    # Whose per cents they are would be misunderstood as its own.
    assert told.share is None
    assert isinstance(other.outcome(), Planned)


@pytest.mark.parametrize("way", [planners.CRASH, planners.DEFECT])
def test_a_crash_is_told_and_the_process_restarted(shared_pool, way):
    tab, other = Tab(shared_pool), Tab(shared_pool, "other")
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


def test_a_defect_leaves_its_traceback_in_the_terminal(spawning, capfd):
    # Made here: between a test's set-up and its call, pytest shows no process where to write.
    with contextlib.closing(WorkerPool(SyntheticPlanner, processes=1)) as pool:
        tab = Tab(pool)
        tab.plan(planners.DEFECT)
        assert "exit status 1" in tab.outcome().message
    assert "ZeroDivisionError: a defect" in capfd.readouterr().err


def test_a_process_that_cannot_start_is_told_and_does_not_spin(spawning, capfd):
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
