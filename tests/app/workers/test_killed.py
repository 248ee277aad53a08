"""Computing processes that are killed from outside, as by a machine that is short of memory."""

import os
import signal
import threading
import time
from contextlib import closing

import pytest

from app.workers.pool import WorkerPool
from app.workers.reports import Failed, Planned
from app.workers.tasks import PlanJump, SimulateSeeds
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from tests.app import planners
from tests.app.planners import SyntheticPlanner
from tests.app.pool_tab import Tab
from tests.app.synthetic_plan import synthetic_plan
from tests.app.waits import wait_until


@pytest.mark.parametrize("task", ["plan", "seeds"])
def test_a_job_whose_process_is_killed_is_begun_again_once(task):
    with closing(WorkerPool(SyntheticPlanner, processes=2)) as pool:
        tab = Tab(pool)
        if task == "plan":
            job = tab.plan(planners.STUBBORN)
        else:
            plan = synthetic_plan(Jump(twist=1.0))
            job = tab.submit(SimulateSeeds(plan, Scenario(), (1, planners.STUBBORNLY)))
        killed = set()
        for _ in range(2):
            wait_until(lambda: at_work(pool, job) - killed, "the process")
            (working,) = at_work(pool, job) - killed
            os.kill(working, signal.SIGKILL)
            killed.add(working)
        assert tab.outcome() == Failed(
            job, "The computing process ended unexpectedly (signal 9) and was restarted."
        )
        tab.plan()
        assert isinstance(tab.outcome(), Planned)


def at_work(pool, job):
    """Processes that work on a job, or on the part of it that does not end."""
    return {
        member.process.id
        for member in pool._members
        if member.working_on is not None and member.working_on.number == job
        if isinstance(member.task, PlanJump) or member.task.scenario.seed == planners.STUBBORNLY
    }


def test_a_newer_request_is_planned_in_place_of_the_one_whose_process_is_killed():
    with closing(WorkerPool(SyntheticPlanner, processes=1)) as pool:
        tab = Tab(pool)
        job = tab.plan(planners.STUBBORN)
        tab.wait_until_running(job)
        newer = tab.plan()
        os.kill(pool.process_ids[0], signal.SIGKILL)
        assert isinstance(tab.outcome(), Failed)
        assert tab.outcome().job == newer


def test_a_process_that_is_killed_as_it_starts_starts_once_more():
    with closing(WorkerPool(SyntheticPlanner, processes=1)) as pool:
        wait_until(lambda: pool.process_ids[0] is not None, "the process")
        killed = pool.process_ids[0]
        os.kill(killed, signal.SIGKILL)
        tab = Tab(pool)
        tab.plan()
        assert isinstance(tab.outcome(), Planned)
        assert pool.process_ids[0] != killed


def test_a_process_that_is_killed_as_it_is_given_a_job_starts_once_more(monkeypatch):
    start, ended = threading.Thread.start, threading.Event()

    def late(thread):  # as on a machine with more threads than processors
        if thread.name.endswith("-writer") and not ended.is_set():
            os.kill(pool.process_ids[0], signal.SIGKILL)
            ended.set()
            time.sleep(0.3)
        start(thread)

    with closing(WorkerPool(SyntheticPlanner, processes=1)) as pool:
        wait_until(lambda: pool._members[0].idle, "the process")
        monkeypatch.setattr(threading.Thread, "start", late)
        tab = Tab(pool)
        tab.plan()
        assert isinstance(tab.outcome(), Planned)
        assert ended.is_set()
