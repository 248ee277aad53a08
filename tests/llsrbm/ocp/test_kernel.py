"""The kernel against NumPy, and that Fatrop really uses it."""

import ctypes
import shutil
import subprocess
import sys

import numpy as np
import pytest

from llsrbm.ocp.compiled import compiler
from llsrbm.ocp.kernel import SOURCE, product
from llsrbm.ocp.small_library import compiled_library

pytestmark = pytest.mark.skipif(
    shutil.which("cc") is None or not sys.platform.startswith("linux"), reason="no C compiler"
)


@pytest.fixture(autouse=True)
def switched_on(monkeypatch, tmp_path):
    monkeypatch.setenv("LLSRBM_COMPILE", "1")
    monkeypatch.setenv("LLSRBM_CACHE", str(tmp_path))


def test_product(tmp_path):
    library = ctypes.CDLL(str(compiled_library(compiler(), SOURCE)))
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


SCRIPT = """
import sys
import numpy as np
from llsrbm.ocp import solvers
from llsrbm.ocp.compiled import compiler
from llsrbm.ocp.kernel import NAME, load_kernel
from llsrbm.ocp.transcription import Transcription
from tests.llsrbm.ocp.cart import INTERVALS, horizon, problem
if sys.argv[1] == "own":
    assert load_kernel(compiler())
solver = solvers.by_name("fatrop").build(Transcription(horizon()))
print(*solver.solve(problem(0.9, drag=0.5), np.zeros(3 * INTERVALS + 2)).variables)
"""


def test_solutions():
    texts = [
        subprocess.run(
            [sys.executable, "-c", SCRIPT, which], capture_output=True, text=True, check=True
        ).stdout
        for which in ("own", "original")
    ]
    own, original = (np.array(text.split(), dtype=float) for text in texts)
    assert own.size == original.size > 20
    np.testing.assert_allclose(own, original, atol=1e-9)
