"""Compiled functions give the numbers that CasADi's own evaluation gives, and nobody waits."""

import gc
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from llsrbm.ocp import compile_job, solvers
from llsrbm.ocp.compile_job import failed
from llsrbm.ocp.compiled import Compiler, Library, _loop, c_files, compiler, packed
from llsrbm.ocp.solvers import SolveOptions
from llsrbm.ocp.transcription import FUNCTIONS
from tests.llsrbm.ocp.cart import INTERVALS, problem, transcription

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
GUESS = np.zeros(3 * INTERVALS + 2)


@pytest.fixture(autouse=True)
def switched_on(monkeypatch):
    monkeypatch.setenv("LLSRBM_COMPILE", "1")


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """Of the cart."""
    found = Library(tmp_path_factory.mktemp("cache") / "kind" / "cart.so")
    found.path.parent.mkdir()
    found.compile(make_compiler(), packed(c_files(transcription())))
    found.wait()
    return found


def make_compiler():
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LLSRBM_COMPILE", "1")
        return compiler()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_numbers(library, name):
    rng = np.random.default_rng(1)
    one, other = transcription().functions[name], library.load().functions[name]
    sizes = GUESS.size, 4, 1, problem(1.0).lower.size
    arguments = [rng.normal(size=size) for size in sizes][: one.n_in()]
    for a, b in zip(one.call(arguments), other.call(arguments), strict=True):
        assert a.sparsity() == b.sparsity()
        np.testing.assert_allclose(b.nonzeros(), a.nonzeros(), rtol=1e-13, atol=1e-14)


def test_solutions(library):
    kind = solvers.by_name("fatrop")
    plain, fast = kind(transcription()), kind(library.load())
    task = problem(0.9, drag=0.5, weights=(1.0, 3.0))
    for options in (solvers.FROM_GUESS, SolveOptions(mu=1e-3, iterations=60)):
        one, other = (solver.solve(task, GUESS, options) for solver in (plain, fast))
        assert other.converged
        assert other.iterations == one.iterations
        np.testing.assert_allclose(other.variables, one.variables, atol=1e-8)
    moved = problem(0.95, drag=0.5, weights=(1.0, 3.0))
    a, b = plain.follow(moved, one), fast.follow(moved, one)
    assert b.converged
    np.testing.assert_allclose(b.variables, a.variables, atol=1e-8)


def test_a_solver_takes_them_when_they_are_there(library):
    there = []
    solver = solvers.by_name("fatrop")(transcription())
    solver.replace_by(lambda: library.load() if there else None)
    before = solver.solve(problem(1.0), GUESS)
    assert not solver.function("nlp_g").is_a("External", True)
    there.append(True)
    after = solver.solve(problem(1.0), GUESS)
    assert solver.function("nlp_g").is_a("External", True)
    np.testing.assert_allclose(after.variables, before.variables, atol=1e-8)


def program(tmp_path, text):
    """A compiler that does what a shell script says."""
    path = tmp_path / "cc"
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return str(path)


def attempt(tmp_path, command):
    """Have a library compiled, and wait; True if anything was tried."""
    (tmp_path / "kind").mkdir(exist_ok=True)
    library = Library(tmp_path / "kind" / "cart.so")
    library.compile(Compiler((command,), ""), packed({"a.c": "no C"}))
    tried = library._job is not None
    library.wait()
    assert library.load() is None
    return tried


def test_a_compiler_that_fails_is_tried_again_the_next_day(tmp_path, caplog):
    assert attempt(tmp_path, "cc")
    assert "going on without compiled functions: cc: status 1" in caplog.text
    assert not attempt(tmp_path, "cc")
    os.utime(failed(tmp_path / "kind" / "cart.so"), (0, 0))
    assert attempt(tmp_path, "cc")


ASKER = """
import sys, time
from pathlib import Path
from llsrbm.ocp.compiled import Compiler, Library, packed
Library(Path(sys.argv[1])).compile(Compiler((sys.argv[2],), ""), packed({"a.c": "no C"}))
print(flush=True)
time.sleep(60)
"""


def test_a_compilation_ends_with_its_asker_and_leaves_nothing(tmp_path):
    """Its compiler and what that runs too, also where the asker is killed."""
    target, pids = tmp_path / "kind" / "cart.so", tmp_path / "pids"
    target.parent.mkdir()
    command = program(tmp_path, f"echo half > cart.so; sleep 60 & echo $$ $! > {pids}; wait")
    asker = subprocess.Popen(
        [sys.executable, "-c", ASKER, str(target), command], stdout=subprocess.PIPE
    )
    asker.stdout.readline()
    assert within(30.0, lambda: pids.exists() and len(pids.read_text().split()) == 2)
    asker.kill()
    asker.wait()
    assert within(10.0, lambda: not any(map(runs, pids.read_text().split())))
    assert within(10.0, lambda: not [*target.parent.iterdir()])


def runs(pid):
    try:
        return ") Z " not in Path("/proc", pid, "stat").read_text()
    except OSError:  # it is gone
        return False


def within(seconds, holds):
    deadline = time.monotonic() + seconds
    while not holds() and time.monotonic() < deadline:
        time.sleep(0.01)
    return holds()


def test_a_compiler_that_does_not_end_is_ended_with_all_it_runs(tmp_path, monkeypatch):
    monkeypatch.setattr(compile_job, "LONGEST", 0.3)
    command = program(tmp_path, "sleep 30 & echo $! > child; wait")
    with pytest.raises(OSError, match=r"not finished after 0\.3 s"):
        compile_job.run([command], str(tmp_path))
    child = (tmp_path / "child").read_text().strip()
    assert within(10.0, lambda: not runs(child))


def test_what_is_no_library_is_reported(tmp_path, caplog):
    library = Library(tmp_path / "cart.so")
    assert library.load() is None
    assert caplog.text == ""
    library.path.write_bytes(b"half of it")
    assert library.load() is None
    assert "is damaged; it is made anew" in caplog.text
    assert not library.path.exists()
    library.path.write_bytes(b"no library")
    compile_job.seal(library.path)
    assert library.load() is None
    assert "cannot be loaded" in caplog.text


def test_without_a_compiler(monkeypatch):
    assert compiler() is not None
    monkeypatch.setenv("CC", "no-such-compiler")
    assert compiler() is None
    monkeypatch.setenv("CC", "false")
    assert compiler() is None
    monkeypatch.delenv("CC")
    monkeypatch.setenv("LLSRBM_COMPILE", "0")
    assert compiler() is None


@pytest.mark.skipif(not Path("/proc/self/autogroup").exists(), reason="no shares of sessions")
def test_a_session_of_its_own_yields_to_all_others():
    program = "from llsrbm.ocp.compile_job import yield_to_others as y; y(); import pathlib;"
    program += "print(pathlib.Path('/proc/self/autogroup').read_text())"
    own = subprocess.run(
        [sys.executable, "-c", program], start_new_session=True, capture_output=True, text=True
    )
    assert own.stdout.split()[-1] == "19"


def test_functions_that_live_longer_than_their_files_end_in_silence(tmp_path, capfd):
    x = ca.SX.sym("x")
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    loop = _loop(ca.Function("doubled", [x], [2 * x]), [3], 3, str(scratch))
    assert list(scratch.iterdir())
    shutil.rmtree(scratch)
    del loop
    gc.collect()
    assert capfd.readouterr() == ("", "")
