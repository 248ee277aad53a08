"""The kernel against NumPy, solves with both patches, and an end of what Fatrop would never end."""

import ctypes
import shutil
import sys

import numpy as np
import pytest

from llsrbm.ocp.compiled import compiler
from llsrbm.ocp.fatrop_patches import KERNEL, compiled, product
from tests.llsrbm.processes import printed

pytestmark = pytest.mark.skipif(
    shutil.which("cc") is None or not sys.platform.startswith("linux"), reason="no C compiler"
)


@pytest.fixture(autouse=True)
def switched_on(monkeypatch, tmp_path):
    monkeypatch.setenv("LLSRBM_COMPILE", "1")
    monkeypatch.setenv("LLSRBM_CACHE", str(tmp_path))


def test_product(tmp_path):
    library = ctypes.CDLL(str(compiled(compiler(), KERNEL)))
    assert len([*tmp_path.glob("kernel/*")]) == 1
    rng = np.random.default_rng(3)
    for n in (0, 1, 2, 3, 8, 53):
        A, B, C = rng.normal(size=(4, n)), rng.normal(size=(4, n)), rng.normal(size=(4, 4))
        for alpha, beta in ((1.0, 1.0), (-1.0, 0.0), (0.3, -2.0)):
            expected = beta * C + alpha * A @ B.T
            np.testing.assert_allclose(
                product(library, alpha, A, B, beta, C), expected, rtol=1e-13, atol=1e-13
            )
        nothing = np.full((4, 4), np.nan)  # with beta = 0 C is not read
        assert np.isfinite(product(library, 1.0, A, B, 0.0, nothing)).all()


SOLUTION = """
import sys
import numpy as np
from llsrbm.ocp import fatrop_patches, solvers
from llsrbm.ocp.compiled import compiler
from llsrbm.ocp.transcription import Transcription
from tests.llsrbm.ocp.cart import INTERVALS, horizon, problem
if sys.argv[1] == "patched":
    fatrop_patches.load(compiler())
solver = solvers.by_name("fatrop")(Transcription(horizon()))
print(*solver.solve(problem(0.9, drag=0.5), np.zeros(3 * INTERVALS + 2)).variables)
"""


def test_solutions_are_the_same(tmp_path):
    original, patched = (
        np.array(printed(SOLUTION, w).split(), float) for w in ("original", "patched")
    )
    assert len([*tmp_path.glob("kernel/*")]) == 2
    assert patched.size == original.size > 20
    np.testing.assert_allclose(patched, original, atol=1e-9)


# A cost that falls so steeply that no regularisation within reach bends it.
ENDLESS = """
import casadi as ca
from llsrbm.ocp import fatrop_patches
from llsrbm.ocp.compiled import compiler
fatrop_patches.load(compiler())
x = ca.SX.sym("x", 2)
options = {"print_time": False, "error_on_fail": False, "fatrop": {"print_level": 0}}
for weight in (1.0, -1e200, 1.0):
    problem = {"x": x, "f": weight * ca.sumsqr(x - 3)}
    solver = ca.nlpsol("solver", "fatrop", problem, options)
    solver(x0=1.0)
    print(solver.stats()["success"], fatrop_patches.given_up(), sep="", end=" ")
"""


def test_an_endless_search_is_given_up():
    assert printed(ENDLESS).split()[-3:] == ["True0", "False1", "True1"]


# A cost that falls for ever.
CANCELLED = """
import casadi as ca
import time
from llsrbm.errors import Cancelled
from llsrbm.ocp import fatrop_patches
from llsrbm.ocp.compiled import compiler
from llsrbm.ocp.progress import attended, when_idle
fatrop_patches.load(compiler())
x = ca.SX.sym("x", 2)
def solve(cost, iterations):
    options = {"print_level": 0, "max_iter": iterations, "tolerance": 1e-300}
    options = {"print_time": False, "error_on_fail": False, "fatrop": options}
    solver = ca.nlpsol("solver", "fatrop", {"x": x, "f": cost}, options)
    solver(x0=1.0)
    return solver.stats()["fatrop"]["iterations_count"]
begun = time.monotonic()
def endless():
    return solve(ca.sum1(x), 10**8)
try:
    attended(endless, lambda: None, None, lambda: time.monotonic() > begun + 0.5)
except Cancelled:
    when_idle(lambda: time.monotonic() > begun + 30)
    print(solve(ca.sumsqr(x - 3), 5) > 1)
"""


def test_a_cancelled_solve_ends():
    assert printed(CANCELLED).split()[-1] == "True"
