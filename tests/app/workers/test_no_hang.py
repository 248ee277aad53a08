"""Nothing keeps the pool from answering: defects, stopped processes, full queues, bad listeners."""

import logging
import os
import signal
import threading
import time
from contextlib import closing

import pytest

from app.workers import member, tasks, waiting
from app.workers import pool as pool_module
from app.workers.pool import WorkerPool
from app.workers.process import Process
from app.workers.refusals import BROKEN, BUSY, CLOSED, DEFECT
from app.workers.reports import Cancelled, Failed, Planned, Progress
from app.workers.tasks import OpenFile, PlanJump
from llsrbm.request.jump import Jump
from tests.app import planners
from tests.app.planners import SyntheticPlanner, hanging_factory
from tests.app.pool_tab import Tab
from tests.app.waits import wait_until

PLAN = PlanJump(Jump())
LARGE = OpenFile("large.npz", bytes(8 * 1024**2), "anymal")  # more than a socket takes unread


@pytest.fixture
def own_pool():
    with closing(WorkerPool(SyntheticPlanner, processes=1)) as own:
        yield own


@pytest.fixture(scope="module")
def pool():
    with closing(WorkerPool(SyntheticPlanner, processes=1)) as shared:
        yield shared


def raising(monkeypatch, pool, times=1):
    """Handing out meets an exception that nothing foresees, the next time or times."""
    next_, left = pool._waiting.next, [times]

    def broken(members):
        if left[0]:
            left[0] -= 1
            raise ZeroDivisionError("a defect of the pool")
        return next_(members)

    monkeypatch.setattr(pool._waiting, "next", broken)


def ended(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


def test_after_a_defect_of_the_pool_all_are_answered_and_it_goes_on(monkeypatch, own_pool, caplog):
    tabs = [Tab(own_pool, name) for name in ("running", "waiting")]
    asked = [tabs[0].plan(planners.SLOW)]
    tabs[0].wait_until_running(asked[0])
    asked.append(tabs[1].plan())
    process = own_pool.process_ids[0]
    raising(monkeypatch, own_pool)
    own_pool.cancel("nobody")  # wakes it
    for tab, job in zip(tabs, asked, strict=True):
        assert tab.outcome() == Failed(job, DEFECT)
    tabs[0].plan()
    assert isinstance(tabs[0].outcome(), Planned)
    wait_until(lambda: ended(process), "its end", 5)
    assert "a defect of the pool" in caplog.text
    assert tabs[1].reports.empty()


def test_a_lasting_defect_ends_in_refusals_not_in_waiting(monkeypatch, own_pool):
    tab = Tab(own_pool)
    job = tab.plan(planners.SLOW)
    tab.wait_until_running(job)
    process = own_pool.process_ids[0]
    raising(monkeypatch, own_pool, times=1000)
    first = tab.plan()
    outcomes = {(report := tab.outcome()).job: report.message for _ in range(2)}
    assert set(outcomes) == {job, first}
    assert set(outcomes.values()) <= {DEFECT, BROKEN}
    wait_until(lambda: ended(process), "its end", 5)
    wait_until(
        lambda: not any(t.is_alive() for t in own_pool._crew._threads), "its threads' end", 5
    )
    for _ in range(3):
        began = time.monotonic()
        job = tab.plan()
        assert tab.reports.get_nowait() == Failed(job, BROKEN)
        assert time.monotonic() - began < 1.0
    own_pool.cancel("tab")
    own_pool.forget("tab")


def test_a_task_that_cannot_be_sent_fails_alone(pool):
    tab = Tab(pool)
    tab.plan()
    tab.outcome()
    process = pool.process_ids
    job = tab.submit(PlanJump(Jump(), near=threading.Lock()))
    assert tab.outcome() == Failed(job, DEFECT)
    tab.plan()
    assert isinstance(tab.outcome(), Planned)
    assert pool.process_ids == process


def test_a_listener_is_called_outside_the_lock_and_may_ask_the_pool(pool):
    blocked, entered = threading.Event(), threading.Event()

    def listen(report):
        entered.set()
        blocked.wait(20)

    pool.submit("blocking", PLAN, listen)
    assert entered.wait(20)
    tab = Tab(pool)
    began = time.monotonic()
    job = tab.plan(planners.STUBBORN)
    pool.cancel("tab")
    pool.forget("nobody")
    assert time.monotonic() - began < 0.5
    blocked.set()
    assert tab.outcome() == Cancelled(job)


def test_a_log_that_nobody_reads_delays_no_job(pool, monkeypatch):
    blocked = threading.Event()

    class Unread(logging.Handler):
        def emit(self, record):
            blocked.wait(20)

    handler = Unread()
    logging.getLogger("app.workers.pool").addHandler(handler)
    try:
        tab = Tab(pool)
        tab.plan(planners.CRASH)
        assert isinstance(tab.outcome(), Failed)
        tab.plan()
        assert isinstance(tab.outcome(), Planned)
    finally:
        blocked.set()
        logging.getLogger("app.workers.pool").removeHandler(handler)


def places(pool):
    return [member for member in pool._members if not member.spare]


def with_both_processes(pool, tab, other):
    """Wait until two jobs can run side by side."""
    for each in (tab, other):
        each.plan(planners.SLOW)
    assert {type(each.outcome()) for each in (tab, other)} == {Planned}
    wait_until(lambda: all(member.idle for member in places(pool)), "both at rest")


@pytest.mark.parametrize("when", ["in mid-work", "before it reads a large job"])
def test_a_stopped_process_delays_no_other_tab_and_is_replaced(when):
    """It does not end when it is told to, either: it has to be killed."""
    with closing(WorkerPool(SyntheticPlanner, processes=2)) as pool:
        tab, other = Tab(pool), Tab(pool, "other")
        with_both_processes(pool, tab, other)
        if when == "in mid-work":
            job = tab.plan(planners.STUBBORN)
            tab.wait_until_running(job)
            (working,) = (m for m in pool._members if m.working_on is not None)
            os.kill(stopped := working.process.id, signal.SIGSTOP)
        else:
            os.kill(stopped := pool.process_ids[0], signal.SIGSTOP)
            job = tab.submit(LARGE)
            time.sleep(0.1)
            assert pool._members[0].working_on.number == job
        other.plan()
        assert isinstance(other.outcome(timeout=5), Planned)
        pool.cancel("tab")
        assert tab.outcome(timeout=1) == Cancelled(job)
        other.plan()
        assert isinstance(other.outcome(timeout=5), Planned)
        wait_until(lambda: ended(stopped), "its end", 5)
        with_both_processes(pool, tab, other)
        assert stopped not in pool.process_ids


def test_closing_has_an_end_even_if_a_process_does_not():
    pool = WorkerPool(SyntheticPlanner, processes=1)
    tab, waiting = Tab(pool), Tab(pool, "waiting")
    tab.wait_until_running(tab.plan(planners.STUBBORN))
    job = waiting.plan()
    stopped = pool.process_ids[0]
    os.kill(stopped, signal.SIGSTOP)
    began = time.monotonic()
    pool.close()
    assert time.monotonic() - began < pool_module.CLOSE_PATIENCE
    wait_until(lambda: ended(stopped), "its end", 1)
    assert waiting.outcome(timeout=1) == Failed(job, CLOSED)
    job = tab.plan()
    assert tab.outcome(timeout=1).message == CLOSED  # of the one that ran
    assert tab.outcome(timeout=1) == Failed(job, CLOSED)


def test_a_full_queue_refuses_new_tabs_at_once_and_replaces_jobs_of_those_that_wait(
    monkeypatch, pool
):
    monkeypatch.setattr(waiting, "MOST_WAITING", 3)
    busy = Tab(pool, "busy")
    busy.wait_until_running(busy.plan(planners.SLOW))
    tabs = [Tab(pool, number) for number in range(5)]
    asked = [tab.plan() for tab in tabs]
    for tab, job in zip(tabs[3:], asked[3:], strict=True):
        assert tab.reports.get_nowait() == Failed(job, BUSY)
    newer = tabs[0].plan(forward=0.1)
    assert (report := tabs[0].outcome()).job == newer
    assert isinstance(report, Planned)
    assert {type(tab.outcome()) for tab in tabs[1:3]} == {Planned}
    tabs[4].plan()
    assert isinstance(tabs[4].outcome(), Planned)


def test_a_process_that_never_gets_ready_counts_as_one_that_does_not_start(monkeypatch, caplog):
    monkeypatch.setattr(Process, "start_patience", 0.5)
    with closing(WorkerPool(hanging_factory, processes=1)) as pool:
        tab = Tab(pool)
        job = tab.plan()
        report = tab.outcome()
        assert report.job == job
        assert "does not start (signal 9)" in report.message
        assert pool.process_ids == (None,)
    assert "was not ready in time" in caplog.text


def test_a_job_without_a_sign_of_life_is_given_up(monkeypatch):
    for module in (member, pool_module):
        monkeypatch.setattr(module, "SILENCE", 2.0)  # a busy machine is silent for a while, too
    with closing(WorkerPool(SyntheticPlanner, processes=1)) as pool:
        tab = Tab(pool)
        job = tab.plan(planners.STUBBORN)
        report = tab.outcome()
        assert report.job == job
        assert "no sign of life" in report.message
        # What reports now and then goes on as long as it likes.
        tab.plan(planners.ITERATING)
        assert isinstance(tab.outcome(), Planned)


def test_a_file_that_takes_too_long_is_given_up_and_others_are_planned(monkeypatch):
    monkeypatch.setattr(tasks.OpenFile, "limit", 1.0)
    with closing(WorkerPool(SyntheticPlanner, processes=2)) as pool:
        tabs = Tab(pool), Tab(pool, "second")
        jobs = [tab.submit(OpenFile("slow.zip", b"", "anymal")) for tab in tabs]
        other = Tab(pool, "other")
        with_one_process = Tab(pool, "planning")
        with_one_process.plan()
        assert isinstance(with_one_process.outcome(timeout=20), Planned)
        other.plan()
        assert isinstance(other.outcome(), Planned)
        pool.cancel("second")
        assert tabs[1].outcome(timeout=1) == Cancelled(jobs[1])
        assert tabs[0].outcome() == Failed(jobs[0], "It took more than 1 s and was stopped.")
        tabs[0].plan()
        assert isinstance(tabs[0].outcome(), Planned)


def test_nothing_follows_an_outcome_however_tabs_cancel(pool):
    """Cancelled from several threads at all moments of a job that reports all the time."""
    reports, lock = {}, threading.Lock()

    def listen(report):
        with lock:
            reports.setdefault(report.job, []).append(report)

    def ask(name):
        for delay in (0.0, 0.003, 0.01, 0.02, 0.05, 0.13):
            pool.submit(name, PlanJump(Jump(twist=planners.ITERATING)), listen)
            time.sleep(delay)
            pool.cancel(name)

    threads = [threading.Thread(target=ask, args=(name,)) for name in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    tab = Tab(pool)
    tab.plan()
    assert isinstance(tab.outcome(), Planned)
    assert len(reports) == 24
    for job, heard in reports.items():
        assert heard[-1] == Cancelled(job)
        assert all(isinstance(report, Progress) for report in heard[:-1])
