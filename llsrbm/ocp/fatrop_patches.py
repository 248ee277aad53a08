"""Functions of Fatrop and BLASFEO that are replaced in the whole process, and limits for Fatrop.

`load` puts definitions that it compiles here in front of those of CasADi's wheel, for every solve
of this process with Fatrop or BLASFEO, also by other code that uses CasADi. It needs Linux and a C
compiler, and a solver calls it when it is made; `LLSRBM_COMPILE=0` switches it off. Replaced are

1. `fatrop::LinearSolver::solve_in_place`, of Fatrop's steps and of its restoration's. It calls the
   original. Fatrop answers an indefinite system with more regularisation, and again, without an
   end: where rows have slopes of 1e6 and more no regularisation helps, and it never returns. Here
   the solve is given up after `MOST` such answers in a row, or when it has been cancelled.
2. `kernel_dgemm_nt_4x4_lib4` of BLASFEO, the product of two 4 x 4 blocks, half of a compiled solve:
   the wheel carries the kernel for no processor in particular. This one is written for all and
   compiled for this machine's. It is used where it computes what the original does.

The linker takes the first definition of a name, so both have to be loaded before Fatrop is.

Without them nothing ends Fatrop's search. Limits on rows and scales (below, `MAX_GUESS_MISS` and
`MAX_FOLLOW_MISS` of `llsrbm.ocp.solvers`, `SURE_MISS` of the whole body's rounds) keep solves away
from such slopes, in all known cases but a few; what must end runs in a process that can be killed.
"""

import ctypes
import logging
import os
import subprocess
import sys
import tempfile
from functools import lru_cache
from pathlib import Path

import casadi as ca
import numpy as np

from llsrbm.cache import cache_path, content_key, forget_old
from llsrbm.ocp.compile_job import seal
from llsrbm.ocp.compiled import Compiler, is_whole

_log = logging.getLogger(__name__)

# Rows of drafts reach 5, SLIDER's 12. Where they grow, slopes grow faster: near a solution no step
# leads to rows beyond this, if it does not begin there.
WITHIN = 40.0
# Multipliers of plans reach 22. Where rows leave next to no room they grow without bounds, 1e7 and
# more were seen of robots thrown up hard: rows are not scaled by larger ones.
LARGEST_SCALE = 1e3

# Regularisation begins at 1e-4 and grows by 8, the first time by 100: 40 times make 1e32 and more.
MOST = 40
# `LinearSolver<Pd, System>::solve_in_place(LinearSystem&)`: the names of Pd and System, mangled.
_KINDS = (("12PdSolverOrig", "12PdSystemType"), ("13PdSolverResto", "13PdSystemResto"))
_SEARCHES = tuple(
    f"_ZN6fatrop12LinearSolverINS_{solver}INS_7OcpTypeEEENS_{system}IS2_EEE14"
    "solve_in_placeERNS_12LinearSystemIS5_EE"
    for solver, system in _KINDS
)
_INDEFINITE, _NOT_FULL_RANK, _UNKNOWN = 1, 2, 5  # of what it returns

SEARCH = f"""\
static __thread int failures;
int given_up;
volatile long running, cancelled;
static int judged(int flag) {{
  if (cancelled && cancelled == running) return {_UNKNOWN};
  if (flag != {_INDEFINITE} && flag != {_NOT_FULL_RANK}) failures = 0;
  else if (++failures > {MOST}) {{ failures = 0; given_up++; return {_UNKNOWN}; }}
  return flag;
}}
""" + "".join(
    f"int (*original_{index})(void *, void *);\n"
    f"int {name}(void *solver, void *system)\n"
    f"{{ return judged(original_{index}(solver, system)); }}\n"
    for index, name in enumerate(_SEARCHES)
)

_PRODUCT = "kernel_dgemm_nt_4x4_lib4"
# Kernels that builds for a certain processor have, and the general one has not.
_SPECIAL = ("kernel_dgemm_nt_8x4_lib4", "kernel_dgemm_nt_12x4_lib4")

# D = beta C + alpha A B^T; blocks have their columns one behind the other. Two sums, of even and of
# odd k, so that one need not wait for the other.
KERNEL = f"""\
typedef double four __attribute__((vector_size(32)));
typedef double at __attribute__((vector_size(32), aligned(8)));
void {_PRODUCT}(int n, double *alpha, double *A, double *B, double *beta, double *C, double *D) {{
  four zero = {{0}}, a0 = zero, a1 = zero, a2 = zero, a3 = zero;
  four b0 = zero, b1 = zero, b2 = zero, b3 = zero;
  int k = 0;
  for (; k + 1 < n; k += 2, A += 8, B += 8) {{
    four even = *(at *)A, odd = *(at *)(A + 4);
    a0 += even * B[0]; a1 += even * B[1]; a2 += even * B[2]; a3 += even * B[3];
    b0 += odd * B[4]; b1 += odd * B[5]; b2 += odd * B[6]; b3 += odd * B[7];
  }}
  if (k < n) {{
    four even = *(at *)A;
    a0 += even * B[0]; a1 += even * B[1]; a2 += even * B[2]; a3 += even * B[3];
  }}
  a0 = *alpha * (a0 + b0); a1 = *alpha * (a1 + b1);
  a2 = *alpha * (a2 + b2); a3 = *alpha * (a3 + b3);
  at *c = (at *)C, *d = (at *)D;
  if (*beta != 0.0) {{
    a0 += *beta * c[0]; a1 += *beta * c[1]; a2 += *beta * c[2]; a3 += *beta * c[3];
  }}
  d[0] = a0; d[1] = a1; d[2] = a2; d[3] = a3;
}}
"""
_TOLERANCE = 1e-13

_OPTIONS = ("-O2", "-march=native", "-fPIC", "-shared", "-w", "-x", "c", "-")
_COMPILED_WITHIN = 60.0  # s; it takes a fifth of one


_loaded: list[ctypes.CDLL] = []  # of `SEARCH`


@lru_cache(maxsize=1)
def load(compiler: Compiler) -> None:
    """Replace both functions in this process, unless Fatrop has been loaded already."""
    if not sys.platform.startswith("linux"):  # elsewhere names belong to libraries
        return
    for replace in (_replace_search, _replace_kernel):
        try:
            replace(compiler)
        except (OSError, AttributeError, subprocess.SubprocessError) as error:
            _log.warning("a function of Fatrop's stays as it is: %s", error)


def is_loaded() -> bool:
    """True if endless searches are given up."""
    return bool(_loaded)


def given_up() -> int:
    """Number of solves of this process whose search for a direction was ended."""
    return sum(ctypes.c_int.in_dll(library, "given_up").value for library in _loaded)


def begin(solve: int) -> None:
    """State that the solve with this number, not 0, is the one that runs."""
    for library in _loaded:
        ctypes.c_long.in_dll(library, "running").value = solve


def cancel(solve: int) -> None:
    """End the solve with this number at its next step; without `load` it runs on."""
    for library in _loaded:
        ctypes.c_long.in_dll(library, "cancelled").value = solve


def _replace_search(compiler: Compiler) -> None:
    path = str(compiled(compiler, SEARCH))
    # In front of Fatrop's only when it knows both of them: it calls nothing that is not there.
    found = ctypes.CDLL(path, mode=os.RTLD_LOCAL)
    fatrop = _original("fatrop")
    for index, name in enumerate(_SEARCHES):
        address = ctypes.cast(fatrop[name], ctypes.c_void_p).value
        ctypes.c_void_p.in_dll(found, f"original_{index}").value = address
    ctypes.CDLL(path, mode=os.RTLD_GLOBAL)
    _loaded.append(found)


def _replace_kernel(compiler: Compiler) -> None:
    blasfeo = _original("blasfeo")
    if any(hasattr(blasfeo, name) for name in _SPECIAL):
        return
    path = str(compiled(compiler, KERNEL))
    if not _same(blasfeo, ctypes.CDLL(path, mode=os.RTLD_LOCAL)):
        raise OSError("BLASFEO's kernel computes something else than expected")
    ctypes.CDLL(path, mode=os.RTLD_GLOBAL)


def _original(name: str) -> ctypes.CDLL:
    """A library of CasADi's wheel, its names known to nobody else, as CasADi would load it."""
    found = sorted(Path(ca.__file__).parent.glob(f"lib{name}.so*"))
    if not found:
        raise OSError(f"CasADi comes without lib{name}.so")
    return ctypes.CDLL(str(found[0]), mode=os.RTLD_LAZY | os.RTLD_LOCAL)


def compiled(compiler: Compiler, source: str) -> Path:
    """The library of a source in the cache, compiled if it is not there yet. Raises `OSError,
    subprocess.SubprocessError`: it cannot be made.
    """
    path = cache_path("kernel", content_key(source, repr(_OPTIONS), compiler.identity), ".so")
    if not is_whole(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent) as folder:
            made = Path(folder, path.name)
            subprocess.run(
                [compiler.command[0], *_OPTIONS, "-o", str(made)],
                input=source.encode("ascii"),
                capture_output=True,
                timeout=_COMPILED_WITHIN,
                check=True,
            )
            seal(made)
            made.replace(path)
        forget_old(path)
    return path


def product(
    library: ctypes.CDLL, alpha: float, A: np.ndarray, B: np.ndarray, beta: float, C: np.ndarray
) -> np.ndarray:
    """(4, 4) beta C + alpha A B^T by a library's kernel; A and B (4, n), C (4, 4)."""
    matrices = [np.ascontiguousarray(array.T) for array in (A, B, C, np.zeros((4, 4)))]
    a, b, c, d = (ctypes.c_void_p(array.ctypes.data) for array in matrices)
    scalars = ctypes.byref(ctypes.c_double(alpha)), ctypes.byref(ctypes.c_double(beta))
    getattr(library, _PRODUCT)(A.shape[1], scalars[0], a, b, scalars[1], c, d)
    return matrices[3].T.copy()


def _same(one: ctypes.CDLL, other: ctypes.CDLL) -> bool:
    """True if two libraries' kernels compute the same."""
    rng = np.random.default_rng(0)
    for n in range(10):
        for alpha, beta in ((1.0, 1.0), (-1.0, 1.0), (1.0, 0.0), (0.7, -0.3)):
            A, B, C = rng.normal(size=(4, n)), rng.normal(size=(4, n)), rng.normal(size=(4, 4))
            a, b = (product(library, alpha, A, B, beta, C) for library in (one, other))
            if not np.allclose(a, b, rtol=_TOLERANCE, atol=_TOLERANCE):
                return False
    return True
