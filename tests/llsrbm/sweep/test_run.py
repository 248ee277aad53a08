import asyncio
import os
import signal
import socket
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import distributed
import pytest

from llsrbm.errors import Error, InputError
from llsrbm.sweep import run, shard
from llsrbm.sweep.points import Points
from llsrbm.sweep.table import Folder
from tests.llsrbm.sweep.specs import in_this_process, rows_of, spec, without_planning, work


@pytest.fixture(autouse=True)
def _planned_at_once(monkeypatch):
    without_planning(monkeypatch)


@pytest.fixture(scope="module")
def client():
    with in_this_process(2)() as client:
        yield client


def opened(path):
    points = Points(spec())
    return Folder(path, points, shard.origin(points.spec))


def table(path, client, monkeypatch, jumps_a_shard):
    with opened(path) as folder:
        work(folder, client, monkeypatch, jumps_a_shard)
        folder.finish()
    return rows_of(path / "jumps.parquet")


def test_rows_are_the_same_whatever_the_shards_and_workers(tmp_path, client, monkeypatch):
    with in_this_process(1)() as alone:
        one = table(tmp_path / "1", alone, monkeypatch, 1)
    for jumps_a_shard in (3, 40):
        name = str(jumps_a_shard)
        assert table(tmp_path / name, client, monkeypatch, jumps_a_shard).equals(one)
    assert one["index"].to_pylist() == [*range(40)]


def test_a_sweep_that_was_cut_off_goes_on(tmp_path, client, monkeypatch):
    whole = table(tmp_path / "whole", client, monkeypatch, 7)
    worked = []

    def cut_off(self, made, keep=Folder.write):
        if len(worked) == 4:
            raise KeyboardInterrupt
        worked.extend(made.jumps)
        keep(self, made)

    with monkeypatch.context() as cut:
        cut.setattr(Folder, "write", cut_off)
        with opened(tmp_path / "cut") as folder, pytest.raises(KeyboardInterrupt):
            work(folder, client, cut, 2)
    with opened(tmp_path / "cut") as folder:
        assert sorted(worked) == [n for n in range(40) if folder.done[n]]
        progress = work(folder, client, monkeypatch, 5)
        folder.finish()
    assert progress.begun_at == 4
    assert progress.done == 40
    assert rows_of(tmp_path / "cut" / "jumps.parquet").equals(whole)


def test_figures_add_up(tmp_path, client):
    with opened(tmp_path) as folder:
        progress = work(folder, client)
    assert progress.done == progress.jumps == 40
    assert progress.workers == 2
    assert progress.left == 0
    assert 0 <= progress.busy <= 1


def test_few_shards_are_under_way(tmp_path, client, monkeypatch):
    most = 0

    def counted(self, jumps, submit=run._Work._submit):
        nonlocal most
        future = submit(self, jumps)
        most = max(most, len(self._flight) + 1)
        return future

    monkeypatch.setattr(run._Work, "_submit", counted)
    with opened(tmp_path) as folder:
        work(folder, client, monkeypatch, 1)
    assert most <= run._UNDER_WAY * 2


def test_another_version_on_a_worker_ends_it(tmp_path, client, monkeypatch):
    monkeypatch.setattr(shard, "package_version", lambda: "0.0.9")
    with opened(tmp_path) as folder:
        with pytest.raises(Error, match=r"a worker has llsrbm 0.0.9, this machine 1"):
            run.run(folder, client, {"llsrbm": "1"}, progress=lambda _: None, told=lambda _: None)
        assert not folder.done.any()


@pytest.mark.parametrize(
    "error",
    [ModuleNotFoundError("No module named 'llsrbm'"), FileNotFoundError("mine.toml")],
)
def test_a_worker_without_the_package_or_a_robots_file_ends_it(
    tmp_path, client, monkeypatch, error
):
    def missing(spec):
        raise error

    monkeypatch.setattr(run, "prepare", missing)
    with opened(tmp_path) as folder, pytest.raises(Error, match=r"expected llsrbm .* on every"):
        work(folder, client)


DEADLY = 13
"""The jump that kills its worker."""


def deadly_shard(text, jumps):
    """In place of `run_shard`, in a worker's process."""
    if DEADLY in jumps:
        os.kill(os.getpid(), signal.SIGKILL)
    shard._planned = lambda point, spec: ({"status": "planned"}, None)
    return shard.run_shard(text, jumps)


def test_a_jump_that_kills_workers_is_a_row_and_the_others_are_planned(tmp_path, monkeypatch):
    monkeypatch.setattr(run, "_DEATHS", 0)
    monkeypatch.setattr(run, "run_shard", deadly_shard)
    monkeypatch.setattr(run._Work, "prepare", lambda self: None)
    with run.connected(1, None) as client, opened(tmp_path) as folder:
        work(folder, client, monkeypatch, 2)
        folder.finish()
    found = rows_of(tmp_path / "jumps.parquet").to_pylist()
    assert [row["jump"] for row in found if row["status"] == "failed"] == [DEADLY]
    assert found[DEADLY]["message"] == "1 workers died while they computed it"
    assert sum(row["status"] == "planned" for row in found) == 39


def test_a_scheduler_that_does_not_answer_is_one_line(monkeypatch):
    monkeypatch.setattr(run, "_ANSWER_TIME", 1.0)
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        port = silent.getsockname()[1]
        for address in ("tcp://127.0.0.1:1", "nonsense", f"tcp://127.0.0.1:{port}"):
            said = pytest.raises(InputError, match="no Dask scheduler answers there")
            with said, run.connected(1, address):
                pass


@pytest.fixture
def scheduler(tmp_path):
    """A scheduler in a process of its own, without workers: the process and its address."""
    where = tmp_path / "where.json"
    process = subprocess.Popen(
        [
            *(sys.executable, "-m", "dask", "scheduler", "--host", "127.0.0.1"),
            *("--port", "0", "--no-dashboard", "--scheduler-file", str(where)),
        ],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        with distributed.Client(scheduler_file=str(where)) as client:
            address = client.scheduler.address
        yield process, address
    finally:
        process.kill()
        process.wait()


def test_it_connects_where_an_event_loop_runs(scheduler, monkeypatch):
    """As in a notebook, or beside Playwright."""
    monkeypatch.setattr(run, "_ANSWER_TIME", 30.0)
    _, address = scheduler

    async def workers():
        with run.connected(1, address) as client:
            return len(client.scheduler_info()["workers"])

    with ThreadPoolExecutor(1) as thread:  # this one may have a loop already, of Playwright
        assert thread.submit(asyncio.run, workers()).result() == 0


def test_a_scheduler_that_dies_is_one_line(tmp_path, scheduler, monkeypatch):
    monkeypatch.setattr(run, "_ANSWER_TIME", 30.0)
    process, address = scheduler
    with run.connected(1, address) as client, opened(tmp_path / "out") as folder:
        told = []

        def tell(line):
            told.append(line)
            process.kill()

        with pytest.raises(Error, match=r"the scheduler is lost .*run the same command again"):
            run.run(folder, client, {}, progress=lambda _: None, told=tell)
        assert told == ["waiting for workers"]
