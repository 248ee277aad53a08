"""Computing processes on a dask cluster: they behave as those of this machine, and may be lost."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import closing
from pathlib import Path

import pytest

from app.workers import cluster as cluster_module
from app.workers.cluster import Cluster
from app.workers.pool import WorkerPool
from app.workers.process import Ended
from app.workers.reports import Cancelled, Failed, Planned, Progress, SimulatedSoFar
from app.workers.tasks import PlanJump
from llsrbm.errors import InputError
from llsrbm.request.jump import Jump
from tests.app import planners
from tests.app.planners import SyntheticPlanner, broken_factory
from tests.app.pool_tab import Tab
from tests.app.waits import wait_until

DASK = [sys.executable, "-m", "dask"]
# On a machine without our code: only workers need it.
BARE = """
import sys
sys.modules.update({"app": None, "llsrbm": None})
from dask.__main__ import main
main()
"""
SCHEDULER = [sys.executable, "-c", BARE, "scheduler", "--no-dashboard"]
WORKER = [*DASK, "worker", "--nthreads", "1", "--no-dashboard"]
LOOPBACK = ["--host", "127.0.0.1"]


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Hand:
    """A scheduler and workers, started by hand; a nanny restarts the workers that die."""

    def __init__(self):
        self.address = f"tcp://127.0.0.1:{free_port()}"
        self.running = []
        self.start_scheduler()

    def start_scheduler(self):
        port = self.address.rpartition(":")[2]
        self.scheduler = self.start([*SCHEDULER, *LOOPBACK, "--port", port])

    def start(self, command):
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        process = subprocess.Popen(command, start_new_session=True, **quiet)
        self.running.append(process)
        return process

    def workers(self, count):
        self.start([*WORKER, *LOOPBACK, "--nworkers", str(count), self.address])

    def close(self):
        for process in reversed(self.running):
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@pytest.fixture(scope="module")
def hand():
    with closing(Hand()) as started:
        started.workers(2)
        yield started


@pytest.fixture(scope="module")
def pool(hand):
    """One process here and two there, the first of which is for plans, as all have the solver."""
    cluster = Cluster(hand.address)
    wait_until(lambda: cluster.room == 2, "the cluster", 60)
    with closing(WorkerPool(SyntheticPlanner, processes=1, cluster=cluster)) as shared:
        done = threading.Event()
        shared.warm_up([PlanJump(Jump())], [].append, done.set)
        assert done.wait(20)
        wait_until(lambda: ready(shared, 2), "the cluster", 60)
        yield shared


@pytest.fixture
def tab(pool):
    wait_until(lambda: ready(pool, 2), "the cluster", 60)
    yield Tab(pool)
    pool.cancel("tab")


def ready(pool, remote):
    """Whether so many processes there have their solver, and all else is done, too."""
    able = [m for m in pool._workers if m.idle and m.loaded and not m.todo]
    return [m.remote for m in able] == [False] + [True] * remote


def there(pool):
    """The member that works: one on the cluster."""
    (member,) = (m for m in pool._workers if m.working_on is not None)
    assert member.remote
    return member


def ids(pool):
    return [number for number in pool.process_ids if number is not None]


def test_progress_of_a_simulation_there_is_passed_on_and_cancelling_stops_it(pool, tab):
    processes = ids(pool)
    job = tab.simulate(seed=planners.SLOWLY)
    kinds = set()
    while kinds != {Progress, SimulatedSoFar}:
        report = tab.reports.get(timeout=5)
        assert report.job == job
        kinds.add(type(report))
    member = there(pool)
    pool.cancel("tab")
    assert tab.outcome() == Cancelled(job)
    wait_until(lambda: member.idle, "the cluster", 60)
    assert ids(pool) == processes  # it stopped within its grace, and was not ended


def test_a_job_there_that_does_not_stop_is_ended_with_its_process(pool, tab):
    job = tab.plan(planners.STUBBORN)
    tab.wait_until_running(job)
    process = there(pool).process.id
    began = time.monotonic()
    pool.cancel("tab")
    assert tab.reports.get(timeout=1) == Cancelled(job)
    wait_until(lambda: not alive(process), "the cluster", 60)
    assert time.monotonic() - began < 10.0  # of a minute
    wait_until(lambda: ready(pool, 2), "the cluster", 60)
    assert process not in ids(pool)


def alive(process):
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def test_a_killed_process_there_is_told_to_its_tab_and_replaced(pool, tab):
    job = tab.plan(planners.STUBBORN)
    tab.wait_until_running(job)
    os.kill(process := there(pool).process.id, signal.SIGKILL)
    died = "The computing process ended unexpectedly (signal 9) and was restarted."
    assert tab.outcome() == Failed(job, died)
    wait_until(lambda: ready(pool, 2), "the cluster", 60)
    assert process not in ids(pool)


def test_a_lost_worker_is_told_to_its_tab_and_another_one_takes_its_place(pool, tab):
    job = tab.plan(planners.STUBBORN)
    tab.wait_until_running(job)
    process = there(pool).process.id
    began = time.monotonic()
    os.kill(parent_of(process), signal.SIGKILL)  # the worker; its nanny starts another
    report = tab.outcome()
    assert time.monotonic() - began < 10.0  # of a minute
    assert report.job == job
    assert report.message.startswith("The computing process ended unexpectedly (its worker of the")
    tab.plan(forward=0.2)
    assert tab.outcome().plan.jump.forward == 0.2
    wait_until(lambda: ready(pool, 2), "the cluster", 60)
    assert process not in ids(pool)


def parent_of(process):
    # pid (name) state parent ...
    return int(Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[1])


def test_a_worker_with_other_code_gets_nothing_and_one_line_says_so(hand, monkeypatch, caplog):
    monkeypatch.setattr("app.workers.cluster.package_version", lambda: "0.0.1")
    with closing(Cluster(hand.address)) as cluster:
        time.sleep(1.0)  # it is not said at every look
        assert (cluster.room, cluster.has_room) == (0, False)
    (record,) = caplog.records
    line = record.getMessage()
    assert "is not used: it has llsrbm " in line
    assert "the server llsrbm 0.0.1 (" in line
    assert "\n" not in line


def test_closing_leaves_no_process_behind(hand):
    cluster = Cluster(hand.address)
    with closing(WorkerPool(SyntheticPlanner, processes=1, cluster=cluster)) as pool:
        pool.warm_up([PlanJump(Jump())], [].append, print)
        wait_until(lambda: len(ids(pool)) == 3, "the cluster", 60)
        processes = ids(pool)
    wait_until(lambda: not any(map(alive, processes)), "its end", 5)
    assert not any(map(alive, processes))


def test_a_worker_where_no_process_starts_is_left_alone_for_a_while(hand, caplog):
    with closing(Cluster(hand.address)) as cluster:
        processes = cluster.processes(broken_factory, 2)
        for process in processes:
            assert process.reserve()
        for process in processes:
            with pytest.raises(Ended, match=r"exit status 1|signal 9"):
                next(process.run())
        assert not processes[0].reserve()
        assert cluster.room == 2


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense", "foo://127.0.0.1:8786"])
def test_a_scheduler_that_does_not_answer_is_one_line(address, monkeypatch):
    monkeypatch.setattr(cluster_module, "CONNECT_PATIENCE", 1.0)
    with pytest.raises(InputError, match=r"^--scheduler: .* expected the address of a running"):
        Cluster(address)


def test_a_lost_cluster_is_one_line_and_the_server_s_processes_go_on(
    hand, pool, tab, monkeypatch, caplog
):
    """The last one here."""
    monkeypatch.setattr(cluster_module, "RETRY_INTERVAL", 0.3)
    remarks = []
    pool.remarked = remarks.append
    job = tab.plan(planners.STUBBORN)
    tab.wait_until_running(job)
    assert there(pool)
    caplog.clear()
    hand.scheduler.kill()
    report = tab.outcome()
    assert (report.job, report.message) == (
        job,
        "The computing process ended unexpectedly (the cluster was lost); please try again.",
    )
    wait_until(lambda: remarks, "a remark", 60)
    assert remarks[0].startswith(f"The cluster at {hand.address} is lost; the processes of")
    assert [record.getMessage() for record in caplog.records] == remarks
    tab.plan()
    assert isinstance(tab.outcome(), Planned)
    hand.start_scheduler()
    hand.workers(1)
    wait_until(lambda: len(remarks) > 1, "another remark", 60)
    assert remarks[1:] == [f"The cluster at {hand.address} is back."]
    able = lambda: [m for m in pool._workers if m.remote and m.idle and m.loaded]  # noqa: E731
    wait_until(able, "another process there", 60)
