"""The computing process behind its client: order, cancelling, crashes."""

from __future__ import annotations

import contextlib
import os
import queue
import signal
import time

import pytest

from app.protocol import (
    Cancelled,
    Failed,
    PlanJump,
    Planned,
    Prepare,
    Prepared,
    Progress,
    Simulated,
    SimulateJump,
)
from app.worker_pool import WorkerPool
from llsrbm.jump import Jump
from llsrbm.trajectory.rollout import Conditions
from tests.app import planners
from tests.app.planners import SyntheticPlanner, broken_factory
from tests.app.synthetic_plan import synthetic_plan


@pytest.fixture(scope="module")
def shared_client():
    client = WorkerPool(SyntheticPlanner)
    yield client
    client.close()


@pytest.fixture
def own_client():
    client = WorkerPool(SyntheticPlanner, cancel_grace=0.2, superseded_grace=0.2)
    yield client
    client.close()


class Tab:
    def __init__(self, client, name="tab"):
        self.client, self.name, self.reports = client, name, queue.SimpleQueue()

    def plan(self, twist=0.0, forward=0.0):
        task = PlanJump(Jump(twist=twist, forward=forward))
        return self.client.submit(self.name, task, self.reports.put)

    def simulate(self, **conditions):
        task = SimulateJump(synthetic_plan(Jump(twist=1.0)), Conditions(**conditions))
        return self.client.submit(self.name, task, self.reports.put)

    def outcome(self, timeout=20.0):
        while isinstance(report := self.reports.get(timeout=timeout), Progress):
            pass
        return report

    def wait_until_running(self, job):
        while (report := self.reports.get(timeout=20)) != Progress(job, "solving"):
            assert isinstance(report, Progress)


def test_a_plan_comes_back_with_its_number_and_its_request(shared_client):
    tab = Tab(shared_client)
    job = tab.plan(forward=0.3)
    report = tab.outcome()
    assert isinstance(report, Planned)
    assert report.job == job
    assert report.plan.jump.forward == 0.3
    assert report.plan.com.shape == (49, 3)


def test_progress_comes_before_the_outcome(shared_client):
    tab = Tab(shared_client)
    job = shared_client.submit("tab", Prepare("anymal"), tab.reports.put)
    assert tab.reports.get(timeout=20) == Progress(job, "preparing anymal")
    assert tab.reports.get(timeout=20) == Prepared(job, "anymal")


def test_who_joins_the_queue_hears_what_is_being_done(shared_client):
    first, second = Tab(shared_client, "first"), Tab(shared_client, "second")
    first.wait_until_running(first.plan(planners.SLOW))
    job = second.plan()
    assert second.reports.get(timeout=0.5) == Progress(job, "solving")
    assert isinstance(second.outcome(), Planned)


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
def test_a_users_error_is_a_message_and_the_process_lives_on(
    shared_client, task, message, with_plan
):
    tab = Tab(shared_client)
    before = shared_client.process_id
    shared_client.submit("tab", task, tab.reports.put)
    report = tab.outcome()
    assert isinstance(report, Failed)
    assert report.message == message
    assert (report.plan is not None) == with_plan
    assert shared_client.process_id == before


def test_the_newest_waiting_request_wins(shared_client):
    busy, tab = Tab(shared_client, "busy"), Tab(shared_client, "tab")
    busy.wait_until_running(busy.plan(planners.SLOW))
    for i in range(20):
        last = tab.plan(forward=i / 100)
    report = tab.outcome()
    assert (report.job, report.plan.jump.forward) == (last, 0.19)
    time.sleep(0.1)
    assert tab.reports.empty()


def test_tabs_take_turns(shared_client):
    """A tab that asks all the time does not keep another waiting."""
    order = queue.SimpleQueue()
    busy = Tab(shared_client, "busy")
    busy.wait_until_running(busy.plan(planners.SLOW))

    def listen(name):
        return lambda report: None if isinstance(report, Progress) else order.put(name)

    jump = PlanJump(Jump())
    for tab in ("first", "second", "third"):
        shared_client.submit(tab, jump, listen(tab))
    for _ in range(5):
        shared_client.submit("first", jump, listen("first"))
        shared_client.submit("third", jump, listen("third"))
    assert [order.get(timeout=20) for _ in range(3)] == ["first", "second", "third"]


def test_progress_of_another_tabs_job_reaches_those_who_wait(own_client):
    busy, tab = Tab(own_client, "busy"), Tab(own_client, "tab")
    busy.plan(planners.SLOW)
    job = tab.plan()
    assert tab.reports.get(timeout=20) == Progress(job, "solving")


def test_cancel_is_heard_at_once_and_a_planner_that_asks_keeps_its_process(own_client):
    tab = Tab(own_client)
    job = tab.plan(planners.SLOW)
    tab.wait_until_running(job)
    process = own_client.process_id
    began = time.monotonic()
    own_client.cancel("tab")
    assert tab.outcome() == Cancelled(job)
    assert time.monotonic() - began < 0.1
    tab.plan()
    assert isinstance(tab.outcome(), Planned)
    assert own_client.process_id == process


def test_a_job_that_does_not_stop_is_ended_with_its_process(own_client):
    tab = Tab(own_client)
    job = tab.plan(planners.STUBBORN)
    tab.wait_until_running(job)
    process = own_client.process_id
    own_client.cancel("tab")
    assert tab.outcome() == Cancelled(job)
    tab.plan()
    assert isinstance(tab.outcome(), Planned)
    assert own_client.process_id != process
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)


def test_cancelling_reaches_waiting_jobs_and_no_other_tab(own_client):
    busy, tab = Tab(own_client, "busy"), Tab(own_client, "tab")
    busy.wait_until_running(busy.plan(planners.SLOW))
    job = tab.plan()
    own_client.cancel("tab")
    assert tab.outcome(timeout=0.5) == Cancelled(job)
    assert isinstance(busy.outcome(), Planned)


def test_cancelling_nothing_is_silent(shared_client):
    shared_client.cancel("tab of nobody")


def test_a_long_job_makes_way_for_its_tabs_newer_request(own_client):
    tab = Tab(own_client)
    old = tab.plan(planners.SLOW)
    tab.wait_until_running(old)
    new = tab.plan()
    assert tab.outcome() == Cancelled(old)
    report = tab.outcome()
    assert (type(report), report.job) == (Planned, new)


def test_a_rollout_comes_back_with_its_number_and_its_conditions(shared_client):
    tab = Tab(shared_client)
    job = tab.simulate(board=0.02, seed=3)
    report = tab.outcome()
    assert isinstance(report, Simulated)
    assert report.job == job
    assert report.rollout.conditions == Conditions(board=0.02, seed=3)
    assert report.rollout.landed


def test_a_simulation_tells_whole_percents_to_its_tab_and_words_to_others(own_client):
    tab, other = Tab(own_client), Tab(own_client, "other")
    job = tab.simulate(seed=planners.SLOWLY)
    assert tab.reports.get(timeout=20) == Progress(job, "simulating, 0 %", 0.0)
    waiting = other.plan()
    assert other.reports.get(timeout=20).job == waiting
    shares = []
    while len(shares) < 4:
        shares.append(tab.reports.get(timeout=20).share)
    assert shares == pytest.approx([0.01, 0.02, 0.03, 0.04])
    own_client.cancel("tab")
    while isinstance(report := other.reports.get(timeout=20), Progress):
        # Whose percents they are would be misunderstood as its own.
        assert report.share is None
    assert isinstance(report, Planned)


def test_a_simulation_makes_way_at_once(own_client):
    tab = Tab(own_client)
    old = tab.simulate(seed=planners.SLOWLY)
    assert tab.reports.get(timeout=20).job == old
    began = time.monotonic()
    new = tab.plan()
    assert tab.outcome() == Cancelled(old)
    assert time.monotonic() - began < 0.15
    assert tab.outcome().job == new


@pytest.mark.parametrize("way", [planners.CRASH, planners.DEFECT])
def test_a_crash_is_told_and_the_process_restarted(own_client, way):
    tab, other = Tab(own_client), Tab(own_client, "other")
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
    with contextlib.closing(WorkerPool(SyntheticPlanner)) as client:
        tab = Tab(client)
        tab.plan(planners.DEFECT)
        assert "exit status 1" in tab.outcome().message
    assert "ZeroDivisionError: a defect" in capfd.readouterr().err


def test_a_process_killed_from_outside_is_replaced(own_client):
    tab = Tab(own_client)
    tab.wait_until_running(tab.plan(planners.SLOW))
    os.kill(own_client.process_id, signal.SIGKILL)
    assert "signal 9" in tab.outcome().message
    tab.plan()
    assert isinstance(tab.outcome(), Planned)


def test_a_process_that_cannot_start_is_told_and_does_not_spin(capfd):
    client = WorkerPool(broken_factory)
    try:
        tab = Tab(client)
        for _ in range(2):
            tab.plan()
            assert "does not start (exit status 1)" in tab.outcome().message
        time.sleep(0.3)
        assert client.process_id is None
    finally:
        client.close()
    assert capfd.readouterr().err.count("ModuleNotFoundError: no planner here") <= 3


def test_closing_ends_the_process_even_in_the_middle_of_a_job():
    client = WorkerPool(SyntheticPlanner)
    tab = Tab(client)
    tab.wait_until_running(tab.plan(planners.STUBBORN))
    process = client.process_id
    client.close()
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)


def test_a_tab_that_has_gone_hears_nothing(own_client):
    tab = Tab(own_client)
    tab.wait_until_running(tab.plan(planners.SLOW))
    own_client.forget("tab")
    other = Tab(own_client, "other")
    other.plan()
    assert isinstance(other.outcome(), Planned)
    assert tab.reports.empty()
