"""How tabs share two computing processes: nobody waits for another or gets its results."""

import math
import os
import signal
import threading
import time
from contextlib import closing
from pathlib import Path

import pytest

from app.workers.pool import WorkerPool
from app.workers.reports import Cancelled, Planned, Progress, Refused, Simulated
from app.workers.tasks import PlanJump, Prepare
from app.workers.waiting import AGAIN
from llsrbm.request.jump import Jump
from tests.app import planners
from tests.app.planners import HeavyPlanner, SyntheticPlanner
from tests.app.pool_tab import Tab
from tests.app.waits import wait_until

MODELS = ("llsrbm-plus", "srbm")


def warmed(heard=None, **options):
    pool = WorkerPool(SyntheticPlanner, processes=2, **options)
    done = threading.Event()
    tasks = [Prepare("anymal"), *(PlanJump(Jump(model=model)) for model in MODELS)]
    pool.warm_up(tasks, [].append if heard is None else heard.append, done.set)
    assert done.wait(120)
    # The first process is through; the second one follows.
    wait_until(
        lambda: all(m.idle and not m.todo for m in pool._members if not m.spare), "its solvers"
    )
    return pool


@pytest.fixture(scope="module")
def pool():
    with closing(warmed()) as shared:
        yield shared


@pytest.fixture
def own_pool():
    with closing(warmed()) as own:
        yield own


def seconds(function):
    began = time.monotonic()
    result = function()
    return time.monotonic() - began, result


@pytest.fixture
def log(planned_log):
    planned_log.unlink(missing_ok=True)
    return planned_log


def test_every_process_loads_what_is_likely_and_the_first_ones_reports_are_heard(log):
    heard = []
    with closing(warmed(heard)) as pool:
        first, second = (str(number) for number in pool.process_ids)
        loaded = [line.split() for line in log.read_text().splitlines()]
    # The likeliest first, and the first process before the other.
    assert loaded[: len(MODELS)] == [[first, model] for model in MODELS]
    assert sorted(loaded) == sorted([pid, model] for pid in (first, second) for model in MODELS)
    outcomes = [report for report in heard if not isinstance(report, Progress)]
    assert [type(report).__name__ for report in outcomes] == ["Prepared", "Planned", "Planned"]


def test_a_process_that_holds_too_much_is_succeeded_by_one_that_has_loaded_the_same(log):
    """However often it happens no request fails, and none waits for a process that starts."""
    with closing(WorkerPool(HeavyPlanner, processes=1)) as pool:
        tab, used = Tab(pool), []
        for _ in range(3):
            tab.plan()
            assert isinstance(tab.outcome(), Planned)
            used += pool.process_ids
            wait_until(lambda last=used[-1]: pool.process_ids != (last,), "a successor", 60)
        wait_until(lambda: not any(map(alive, used)), "the end of the heavy ones", 60)
        planned = [int(line.split()[0]) for line in log.read_text().splitlines()]
    # The first works for the tab alone, each other one loads before.
    assert planned == [used[0], *(process for process in used[1:] for _ in range(2)), planned[-1]]


def alive(process):
    return Path(f"/proc/{process}").exists()


def test_a_request_is_not_kept_waiting_by_what_is_loaded_meanwhile():
    with closing(WorkerPool(SyntheticPlanner, processes=2)) as pool:
        lasting = PlanJump(Jump(twist=planners.STUBBORN, model="srbm"))
        done = threading.Event()
        pool.warm_up([PlanJump(Jump()), lasting], [].append, done.set)
        tab = Tab(pool)
        tab.plan()
        tab.outcome()
        # The second process starts while the first one loads.
        wait_until(lambda: None not in pool.process_ids, "the second process")
        for _ in range(5):
            tab.plan()
            took, report = seconds(tab.outcome)
            assert isinstance(report, Planned)
            assert took < 20.0  # of a minute
        assert not done.is_set()


def test_a_plan_does_not_wait_for_another_tabs_simulations(pool):
    simulating = [Tab(pool, f"simulating {i}") for i in range(2)]
    jobs = [tab.simulate(seed=planners.SLOWLY) for tab in simulating]
    simulating[0].wait_until_running(jobs[0])
    planning = Tab(pool, "planning")
    for _ in range(3):
        planning.plan()
        took, report = seconds(planning.outcome)
        assert isinstance(report, Planned)
        assert took < 3.0  # of five seconds
    for tab, job in zip(simulating, jobs, strict=True):
        pool.cancel(tab.name)
        assert tab.outcome() == Cancelled(job)


def test_a_new_plan_stops_its_tabs_simulation_and_does_not_wait_for_it(pool):
    tab = Tab(pool)
    old = tab.simulate(seed=planners.SLOWLY)
    tab.wait_until_running(old)
    began = time.monotonic()
    new = tab.plan(forward=0.1)
    reports = [tab.outcome(), tab.outcome()]
    assert time.monotonic() - began < 3.0  # of the five seconds that it would take
    assert Cancelled(old) in reports
    (plan,) = (report for report in reports if isinstance(report, Planned))
    assert plan.job == new


def test_a_quick_plan_that_is_superseded_may_finish_and_a_patient_one_is_stopped(pool):
    tab = Tab(pool)
    for patient, outcome in ((False, Planned), (True, Cancelled)):
        old = tab.plan(planners.SLOW, patient=patient)
        tab.wait_until_running(old)
        new = tab.plan()
        outcomes = {report.job: type(report) for report in (tab.outcome(), tab.outcome())}
        assert outcomes == {old: outcome, new: Planned}


def test_who_changes_his_mind_does_not_wait_for_a_solver_that_is_being_built(own_pool):
    tab = Tab(own_pool)
    old = tab.plan(planners.STUBBORN)
    tab.wait_until_running(old)
    new = tab.plan(forward=0.1)
    took, report = seconds(tab.outcome)
    assert (type(report), report.job) == (Planned, new)
    assert took < 20.0  # of a minute
    own_pool.cancel("tab")
    assert tab.outcome() == Cancelled(old)


def test_a_refusal_comes_with_the_nearest_plan_if_there_is_one(pool):
    tab = Tab(pool)
    for twist, nearest in ((math.radians(-170), planners.FARTHEST), (planners.UNSOLVABLE, None)):
        job = tab.plan(twist)
        report = tab.outcome()
        assert isinstance(report, Refused)
        assert (report.job, report.jump.twist) == (job, twist)
        assert not report.last.solved
        assert (report.nearest and report.nearest.jump.twist) == nearest
    assert report.reason == "no convergence: reach violated in flight by 0.02 m"


def test_cancel_is_heard_at_once_and_others_are_served_while_the_process_is_replaced(
    spawning, own_pool
):
    tab, other = Tab(own_pool), Tab(own_pool, "other")
    before = set(own_pool.process_ids)
    job = tab.plan(planners.STUBBORN)
    tab.wait_until_running(job)
    began = time.monotonic()
    own_pool.cancel("tab")
    assert tab.reports.get(timeout=1) == Cancelled(job)
    assert time.monotonic() - began < 0.5  # of a minute
    other.plan()
    took, report = seconds(other.outcome)
    assert isinstance(report, Planned)
    assert took < 1.0  # a process that had to start first would take longer
    wait_until(lambda: len(before & set(own_pool.process_ids)) < 2, "another process", 5)
    assert len(before & set(own_pool.process_ids)) == 1
    tab.plan()
    assert isinstance(tab.outcome(), Planned)


def test_cancelling_one_job_leaves_those_with_smaller_numbers(pool):
    """A tab's newer request keeps its place, so numbers are not in order."""
    first, second = Tab(pool, "first"), Tab(pool, "second")
    busy = Tab(pool, "busy")
    busy.wait_until_running(busy.simulate(seed=planners.SLOWLY))
    first.simulate(seed=1)
    later = second.simulate(seed=planners.SLOWLY)
    latest = first.simulate(seed=planners.SLOWLY)
    pool.cancel("busy")
    first.wait_until_running(latest)
    pool.cancel("first")
    assert first.outcome() == Cancelled(latest)
    second.wait_until_running(later)
    time.sleep(0.2)
    assert second.progress(timeout=5).job == later
    pool.cancel("second")


def test_a_killed_process_is_told_to_its_tab_only_and_replaced_with_its_solvers(log):
    with closing(warmed()) as pool:
        simulating, planning = Tab(pool, "simulating"), Tab(pool, "planning")
        job = simulating.simulate(seed=planners.SLOWLY)
        simulating.wait_until_running(job)
        planned = planning.plan(planners.SLOW)
        planning.wait_until_running(planned)
        killed, spared = pool.process_ids
        log.unlink()
        os.kill(killed, signal.SIGKILL)
        while (report := simulating.progress()).text != f"waiting: {AGAIN}":
            pass
        assert report == Progress(job, f"waiting: {AGAIN}", waiting=True)
        assert isinstance(planning.outcome(), Planned)
        assert (report := simulating.outcome()).job == job
        assert isinstance(report, Simulated)
        assert pool.process_ids[1] == spared
        wanted = {(pool.process_ids[0], model) for model in MODELS}
        wait_until(lambda: wanted <= planned_by(log), "its solvers")
        simulating.simulate(seed=1)
        assert isinstance(simulating.outcome(), Simulated)


def planned_by(log):
    lines = log.read_text().splitlines() if log.exists() else []
    return {(int(pid), model) for pid, model in (line.split() for line in lines)}


def test_ten_tabs_each_get_the_result_of_their_own_last_value(pool):
    tabs = [Tab(pool, i) for i in range(10)]

    def drag(tab):
        for step in range(40):
            job = tab.plan(twist=tab.name / 10, forward=step / 100, patient=False)
            time.sleep(0.005)
        return job

    jobs, threads = {}, []
    for tab in tabs[:5]:
        threads.append(threading.Thread(target=lambda tab=tab: jobs.update({tab: drag(tab)})))
        threads[-1].start()
    for tab in tabs[5:]:
        jobs[tab] = tab.plan(twist=tab.name / 10)
    for thread in threads:
        thread.join()
    for tab in tabs:
        steps, job = [], 0
        while job < jobs[tab]:
            report = tab.outcome()
            assert isinstance(report, Planned)
            assert report.plan.jump.twist == tab.name / 10
            steps.append(report.plan.jump.forward)
            job = report.job
        assert job == jobs[tab]
        assert steps == sorted(steps)
        assert steps[-1] == (0.39 if tab.name < 5 else 0.0)


def test_a_closed_tab_frees_its_work(pool):
    gone, other = Tab(pool, "gone"), Tab(pool, "other")
    gone.wait_until_running(gone.simulate(seed=planners.SLOWLY))
    other.simulate(seed=1)
    pool.forget("gone")
    while not gone.reports.empty():
        gone.reports.get()  # from before
    took, report = seconds(other.outcome)
    assert isinstance(report, Simulated)
    assert took < 3.0  # of five seconds
    assert gone.reports.empty()


def test_a_tab_that_fails_to_listen_does_not_stop_the_others(pool, caplog):
    told = threading.Event()

    def fail(report):
        told.set()
        raise ZeroDivisionError("a defect of this tab")

    pool.submit("failing", PlanJump(Jump()), fail)
    assert told.wait(20)
    tab = Tab(pool)
    tab.plan()
    assert isinstance(tab.outcome(), Planned)
    assert "a defect of this tab" in caplog.text
