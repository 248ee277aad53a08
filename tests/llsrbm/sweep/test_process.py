import os
import signal
import time

import pytest

from llsrbm.errors import Error, InputError
from llsrbm.sweep import jump as process
from llsrbm.sweep.points import Points
from tests.llsrbm.sweep.specs import spec


@pytest.fixture(scope="module", autouse=True)
def _process():
    yield
    process._running.end()
    process._running = None


def point():
    return Points(spec())[7]


def hangs(*_):
    """Ends by no signal that Python sees: as a solver in an endless loop."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM, signal.SIGINT})
    time.sleep(60)


def dies(*_):
    os.kill(os.getpid(), signal.SIGSEGV)


def dies_once(path, *_):
    if not path.exists():
        path.touch()
        dies()
    return "alive"


def refuses(*_):
    raise InputError("no such robot")


def test_a_jump_that_hangs_is_a_row_and_frees_its_worker(monkeypatch):
    process.compute(abs, -1, limit=None)  # started
    monkeypatch.setattr(process, "rows_of", hangs)
    (row,) = process.run_jump(spec(), point(), 0.2)
    assert (row["status"], row["message"]) == ("timed out", "no result within 0.2 s")
    assert row["jump"] == row["index"] == 7
    assert process.compute(abs, -2, limit=None) == 2


def test_a_jump_that_kills_its_process_is_a_row(monkeypatch):
    monkeypatch.setattr(process, "rows_of", dies)
    monkeypatch.setattr(process, "_ATTEMPTS", 1)
    (row,) = process.run_jump(spec(), point(), 60.0)
    assert row["status"] == "failed"
    assert row["message"] == "1 processes died while they computed it (exit status -11)"


@pytest.mark.nightly
def test_a_process_that_dies_by_chance_is_replaced(tmp_path):
    with pytest.raises(process.ProcessDied):
        process.compute(dies_once, tmp_path / "died", limit=60.0)
    assert process.compute(dies_once, tmp_path / "died", limit=60.0) == "alive"


def test_an_error_of_all_jumps_is_raised():
    with pytest.raises(Error, match="InputError: no such robot"):
        process.compute(refuses, limit=60.0)
