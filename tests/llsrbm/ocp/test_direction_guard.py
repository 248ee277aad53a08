"""Fatrop returns where it would look for a direction for ever."""

import shutil
import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(
    shutil.which("cc") is None or not sys.platform.startswith("linux"), reason="no C compiler"
)

# A cost that falls so steeply that no regularisation within reach bends it.
SCRIPT = """
import ctypes
import casadi as ca
from llsrbm.ocp.compiled import compiler
from llsrbm.ocp.direction_guard import load_guard
guard = load_guard(compiler())
x = ca.SX.sym("x", 2)
options = {"print_time": False, "error_on_fail": False, "fatrop": {"print_level": 0}}
for weight in (1.0, -1e200, 1.0):
    problem = {"x": x, "f": weight * ca.sumsqr(x - 3)}
    solver = ca.nlpsol("solver", "fatrop", problem, options)
    solver(x0=1.0)
    given_up = ctypes.c_int.in_dll(guard, "given_up").value
    print(solver.stats()["success"], given_up, sep="", end=" ")
"""


def test_it_gives_up_instead(monkeypatch, tmp_path):
    monkeypatch.setenv("LLSRBM_COMPILE", "1")
    monkeypatch.setenv("LLSRBM_CACHE", str(tmp_path))
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split()[-3:] == ["True0", "False1", "True1"]
