import os
import signal
import socket
import subprocess
import sys

import distributed
import pytest

from llsrbm.errors import Error, InputError
from llsrbm.sweep import jump, run
from tests.llsrbm.sweep.specs import (
    filled,
    in_this_process,
    opened,
    rows_of,
    without_planning,
    work,
)


@pytest.fixture(autouse=True)
def _planned_at_once(monkeypatch):
    without_planning(monkeypatch)


@pytest.fixture(scope="module")
def client():
    with in_this_process() as client:
        yield client


def test_rows_are_those_of_one_process_in_order(tmp_path, client):
    filled(tmp_path / "alone", range(40))
    with opened(tmp_path / "out") as folder:
        progress = work(folder, client)
    assert rows_of(tmp_path / "out").equals(rows_of(tmp_path / "alone"))
    assert progress.done == progress.jumps == 40
    assert progress.workers == 2
    assert 0 <= progress.busy <= 1


def test_a_sweep_that_was_cut_off_goes_on(tmp_path, client, monkeypatch):
    filled(tmp_path / "whole", range(40))

    def cut_off(news):
        if news.done >= 12:
            raise KeyboardInterrupt

    with opened(tmp_path / "cut") as folder, pytest.raises(KeyboardInterrupt):
        work(folder, client, progress=cut_off)
    with opened(tmp_path / "cut") as folder:
        before = int(folder.done.sum())
        # What waits for an earlier jump on the other worker is computed, and not written yet.
        assert 0 < before < 40
        progress = work(folder, client)
    assert (progress.begun_at, progress.done) == (before, 40)
    assert rows_of(tmp_path / "cut").equals(rows_of(tmp_path / "whole"))


def test_another_version_on_a_worker_ends_it(tmp_path, client, monkeypatch):
    with opened(tmp_path, of={"llsrbm": "1"}) as folder:
        monkeypatch.setattr(jump, "package_version", lambda: "0.0.9")
        with pytest.raises(Error, match=r"a worker has llsrbm 0.0.9, here is 1"):
            work(folder, client, of={"llsrbm": "1"})
        assert not folder.done.any()


@pytest.mark.nightly
@pytest.mark.parametrize(
    "error", [ModuleNotFoundError("No module named 'llsrbm'"), FileNotFoundError("mine.toml")]
)
def test_a_worker_without_the_package_or_a_robots_file_ends_it(
    tmp_path, client, monkeypatch, error
):
    def missing(spec, points):
        raise error

    monkeypatch.setattr(run, "run_prepare", missing)
    with opened(tmp_path) as folder, pytest.raises(Error, match=r"expected llsrbm .* on every"):
        work(folder, client)


DEADLY = 13
"""The jump that kills its worker."""


WAITING = """
from time import sleep
from llsrbm.sweep.run import connected
if __name__ == "__main__":  # workers import it
    with connected(1, None) as client:
        under_way = client.submit(sleep, 60)
        print("here", flush=True)
        under_way.result()
"""


def deadly(spec, point, limit):
    """In place of `run_jump`, in a worker's process."""
    if point.number == DEADLY:
        os.kill(os.getpid(), signal.SIGKILL)
    return [{**jump.request_of(point), "index": point.number, "status": "planned"}]


@pytest.mark.nightly
def test_a_jump_that_kills_workers_is_a_row_and_the_others_are_planned(tmp_path, monkeypatch):
    monkeypatch.setattr(run, "_DEATHS", 0)
    monkeypatch.setattr(run, "_UNDER_WAY", 1)
    monkeypatch.setattr(run, "run_jump", deadly)
    monkeypatch.setattr(run._Work, "prepare", lambda self: None)
    with run.connected(1, None) as client, opened(tmp_path) as folder:
        work(folder, client)
    found = rows_of(tmp_path).to_pylist()
    assert [row["jump"] for row in found if row["status"] == "failed"] == [DEADLY]
    assert found[DEADLY]["message"] == "1 workers died while they computed it"
    assert sum(row["status"] == "planned" for row in found) == 39


@pytest.mark.nightly
def test_ctrl_c_ends_workers_without_a_traceback():
    """A terminal sends it to all processes of a command."""
    process = subprocess.Popen(
        [sys.executable, "-c", WAITING],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout.readline() == "here\n"
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert errors.count("Traceback") == 1  # of the command itself, which answers it
    assert "Dask Worker process" not in errors


@pytest.mark.nightly
def test_a_scheduler_that_does_not_answer_is_one_line(monkeypatch):
    monkeypatch.setattr(run, "_ANSWER_TIME", 0.3)
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        port = silent.getsockname()[1]
        for address in ("tcp://127.0.0.1:1", "nonsense", f"tcp://127.0.0.1:{port}"):
            refused = pytest.raises(InputError, match="no Dask scheduler answers there")
            with refused, run.connected(1, address):
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


@pytest.mark.nightly
def test_a_scheduler_that_dies_is_one_line(tmp_path, scheduler, monkeypatch):
    monkeypatch.setattr(run, "_ANSWER_TIME", 3.0)
    process, address = scheduler
    with run.connected(1, address) as client, opened(tmp_path / "out") as folder:
        notes = []

        def note(line):
            notes.append(line)
            process.kill()

        with pytest.raises(Error, match=r"the scheduler is lost .*run the same command again"):
            work(folder, client, note=note)
        assert notes == ["waiting for workers"]
