"""What a kept solver depends on."""

import shutil
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import llsrbm
from llsrbm.errors import InputError
from llsrbm.models import make_model
from llsrbm.ocp import solvers
from llsrbm.ocp.compiled import is_whole
from llsrbm.planning.answer.planner import is_planner_built, planner_for
from llsrbm.planning.problem.constraints import drives
from llsrbm.planning.problem.jump_horizon import make_horizon
from llsrbm.planning.solve import solver_cache
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.planning.solve.solver_cache import Subject, cached_solver, is_compiling
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.llsrbm.ocp.cart import INTERVALS, horizon, problem
from tests.llsrbm.processes import printed

PACKAGE = Path(llsrbm.__file__).parent


def fingerprint():
    robot = load_robot("anymal")
    layout = layout_of(Jump(robot="anymal"), robot)
    whole = make_horizon(make_model("llsrbm-plus", robot), layout)
    return replace(whole, runs=whole.runs[1:3]).fingerprint()  # of the take-off


@pytest.fixture(scope="module")
def original():
    return fingerprint()


def elsewhere():
    """By another process, where sets are in another order."""
    return printed(f"from {__name__} import fingerprint\nprint(fingerprint())").strip()


def test_equal_problems_have_equal_fingerprints(original):
    assert elsewhere() == original


def test_a_number_from_anywhere_changes_the_fingerprint(original, monkeypatch):
    monkeypatch.setattr(drives, "FALL", 0.99 * drives.FALL)
    assert fingerprint() != original


def test_a_fingerprint_is_kept_until_any_module_changes(tmp_path, monkeypatch):
    package = tmp_path / "llsrbm"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(solver_cache, "_PACKAGE", package)
    before = solver_cache.sources.__wrapped__()
    with (package / "mechanics.py").open("a") as file:
        file.write("INSCRIBED = 0.9\n")
    assert solver_cache.sources.__wrapped__() != before
    maker = "ocp/transcription.py"
    assert solver_cache.sources.__wrapped__(maker) == solver_cache.sources(maker)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_the_first_use_does_not_wait_for_a_compiler_and_later_ones_take_its_work(
    tmp_path, monkeypatch
):
    monkeypatch.setenv("LLSRBM_CACHE", str(tmp_path))
    monkeypatch.setenv("LLSRBM_COMPILE", "1")
    built = []
    cart = Subject("cart", "cart", "solver of carts", "", lambda: built.append(1) or horizon())
    fatrop = solvers.by_name("fatrop")

    def compiled(solver):
        return solver.function("nlp_g").is_a("External", True)

    guess = np.zeros(3 * INTERVALS + 2)
    first = cached_solver(fatrop, cart)
    assert not compiled(first)
    assert is_compiling(first)
    plain = first.solve(problem(0.8), guess)
    directory = next(tmp_path.glob("solver-cart-*"))
    deadline = time.monotonic() + 60
    while not [*directory.glob("*.so")] and time.monotonic() < deadline:
        time.sleep(0.02)
    fast = first.solve(problem(0.8), guess)
    assert compiled(first)
    assert not is_compiling(first)
    np.testing.assert_allclose(fast.variables, plain.variables, atol=1e-8)
    for entry in directory.glob("*.z"):
        entry.unlink()  # neither is needed any more
    before = len(built)
    assert compiled(cached_solver(fatrop, cart))
    assert len(built) == before
    # A library that is not as it was made is made again, whatever a loader would say to it.
    library = next(directory.glob("*.so"))
    damaged = b"x" + library.read_bytes()[1:]
    library.unlink()
    library.write_bytes(damaged)
    again = cached_solver(fatrop, cart)
    assert not compiled(again)
    again.settle()
    assert compiled(again)
    assert is_whole(library)
    assert not compiled(cached_solver(solvers.by_name("ipopt"), cart))
    monkeypatch.setenv("LLSRBM_COMPILE", "0")
    assert not compiled(cached_solver(fatrop, cart))


def test_it_is_known_before_whether_a_planner_has_to_be_built(monkeypatch, tmp_path):
    planner_for("anymal", "srbm")
    assert is_planner_built(Jump(model="srbm", twist=0.3))
    monkeypatch.setenv("LLSRBM_CACHE", str(tmp_path))
    assert not is_planner_built(Jump(model="srbm", twist=0.3))
    with pytest.raises(InputError, match="valid: srbm, llsrbm"):
        is_planner_built(Jump(model="other"))
