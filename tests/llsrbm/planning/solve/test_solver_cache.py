"""What a kept solver depends on."""

import shutil
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import llsrbm
from llsrbm.cache import program
from llsrbm.ocp import solvers
from llsrbm.planning.solve import solver_cache
from llsrbm.planning.solve.solver_cache import cached_solver, programs
from tests.llsrbm.ocp.cart import INTERVALS, horizon, problem

PACKAGE = Path(llsrbm.__file__).parent


def test_all_that_makes_the_problem_is_in_the_key_and_no_search():
    known = set(programs())
    needed = ["models/llsrbm_plus.py", "models/leg_drives.py", "ocp/lifting.py", "ocp/batch.py"]
    needed += [
        "ocp/solvers/fatrop.py",
        "planning/stage.py",
        "planning/layout.py",
        "planning/costs.py",
    ]
    needed += ["planning/rotations.py", "planning/headings.py", "planning/constraints/turn.py"]
    needed += ["planning/constraints/__init__.py", "planning/solver_cache.py", "planning/task.py"]
    for name in needed:
        assert program(PACKAGE / name) in known, name
    for name in ("scout", "nearest", "explanation", "planner", "assembly", "residuals"):
        assert program(PACKAGE / "planning" / f"{name}.py") not in known, name


def test_nothing_that_is_imported_is_forgotten():
    """By Python itself, in a fresh process."""
    code = (
        "import sys, llsrbm.planning.solve.solver_cache\n"
        "for name, module in sys.modules.items(): print(name, getattr(module, '__file__', ''))"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    rooms = ("llsrbm.models.", "llsrbm.ocp.", "llsrbm.planning.")
    imported = [line.split() for line in found.stdout.splitlines() if line.startswith(rooms)]
    assert len(imported) > 20
    known = set(programs())
    assert [name for name, path in imported if program(Path(path)) not in known] == []


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_the_first_use_does_not_wait_for_a_compiler_and_later_ones_take_its_work(
    tmp_path, monkeypatch
):
    monkeypatch.setenv("LLSRBM_CACHE", str(tmp_path))
    monkeypatch.setenv("LLSRBM_COMPILE", "1")
    built = []
    monkeypatch.setattr(solver_cache, "make_horizon", lambda *_: built.append(1) or horizon())
    model = SimpleNamespace(name="cart", numbers=dict)
    robot = SimpleNamespace(name="cart", parameters=dict)
    layout, fatrop = SimpleNamespace(name="cart"), solvers.by_name("fatrop")

    def compiled(solver):
        return solver.function("nlp_g").is_a("External", True)

    guess = np.zeros(3 * INTERVALS + 2)
    first = cached_solver(fatrop, model, layout, robot)
    assert not compiled(first)
    plain = first.solve(problem(0.8), guess)
    directory = next(tmp_path.glob("solver-cart-*"))
    deadline = time.monotonic() + 60
    while not [*directory.glob("*.so")] and time.monotonic() < deadline:
        time.sleep(0.02)
    fast = first.solve(problem(0.8), guess)
    assert compiled(first)
    np.testing.assert_allclose(fast.variables, plain.variables, atol=1e-8)
    for entry in directory.glob("*.z"):
        entry.unlink()  # neither is needed any more
    again = cached_solver(fatrop, model, layout, robot)
    assert compiled(again)
    assert len(built) == 1
    assert not compiled(cached_solver(solvers.by_name("ipopt"), model, layout, robot))
    monkeypatch.setenv("LLSRBM_COMPILE", "0")
    assert not compiled(cached_solver(fatrop, model, layout, robot))
