"""Processors that a process may use, and systems that lack what Linux has."""

import os
import subprocess
import sys

import pytest

from llsrbm import processors
from llsrbm.processors import usable_processors
from tests.llsrbm.processes import printed

CODE = """
import os
os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
from app.workers.crew import PROCESSES
from llsrbm.processors import usable_processors
print(usable_processors(), PROCESSES)
"""


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="no affinity on this system")
def test_a_process_counts_the_processors_that_it_may_use():
    assert printed(CODE).split() == ["1", "2"]


@pytest.mark.parametrize(
    ("quota", "count"),
    [("max 100000", 8), ("150000 100000", 2), ("1000 100000", 1), ("", 8), ("1 0", 8)],
)
def test_a_containers_quota_counts(monkeypatch, tmp_path, quota, count):
    (tmp_path / "cpu.max").write_text(quota)
    monkeypatch.setattr(processors, "_QUOTA", tmp_path / "cpu.max")
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)))
    assert usable_processors() == count


HIDDEN = """
import os, sys
sys.modules.update(dict.fromkeys(("fcntl", "resource", "pwd", "grp", "termios", "tty")))
for name in ("nice", "sched_getaffinity", "sched_setscheduler", "getloadavg", "killpg", "getuid"):
    if hasattr(os, name):
        delattr(os, name)
"""
USED = {
    "llsrbm.cli": "llsrbm.cli.main(['formats'])",
    "app.serve": "",
    "app.workers.file_reading": "with app.workers.file_reading.growing_by(1): pass",
    "llsrbm.wire.real_time": "llsrbm.wire.real_time.go_first()",
}


@pytest.mark.parametrize("module", USED)
def test_systems_without_what_posix_has(module):
    """It works, or one line names what is supported: no missing module or function."""
    process = subprocess.run(
        [sys.executable, "-c", f"{HIDDEN}\nimport {module}\n{USED[module]}"],
        capture_output=True,
        text=True,
    )
    lines = process.stderr.strip().splitlines()
    assert process.returncode == 0 or "expected Linux" in lines[-1], process.stderr


def test_a_lock_where_there_are_none(tmp_path):
    code = f"{HIDDEN}\nfrom llsrbm.file_locks import lock\nlock(open(r'{tmp_path}/x', 'w'))"
    process = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert process.stderr.splitlines()[-1].endswith("expected Linux, macOS or Windows")
