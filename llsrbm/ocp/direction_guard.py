"""An end for Fatrop's search for a direction.

Fatrop answers an indefinite system with more regularisation, and again, without an end: where rows
have slopes of 1e6 and more no regularisation helps, and it never returns. A definition in front of
its linear solver's counts how often in a row there was none, and says then what makes Fatrop give
the solve up. It takes a C compiler; without one `LARGEST_SCALE` and `Patience.within` of
`llsrbm.ocp.solvers` keep solves away from such slopes, in all cases that are known but a few.
"""

from __future__ import annotations

import ctypes
import logging
import os
import subprocess
import sys
from functools import lru_cache
from pathlib import Path

import casadi as ca

from llsrbm.ocp.compiled import Compiler
from llsrbm.ocp.small_library import compiled_library

_log = logging.getLogger(__name__)

# Regularisation begins at 1e-4 and grows by 8, the first time by 100: 40 times make 1e32 and more.
MOST = 40
# `LinearSolver<Pd, System>::solve_in_place(LinearSystem&)`, of Fatrop's own steps and of those of
# its restoration: the names of Pd and System, mangled.
_KINDS = (("12PdSolverOrig", "12PdSystemType"), ("13PdSolverResto", "13PdSystemResto"))
NAMES = tuple(
    f"_ZN6fatrop12LinearSolverINS_{solver}INS_7OcpTypeEEENS_{system}IS2_EEE14"
    "solve_in_placeERNS_12LinearSystemIS5_EE"
    for solver, system in _KINDS
)
_INDEFINITE, _NOT_FULL_RANK, _UNKNOWN = 1, 2, 5  # of what it returns

_ONE = """\
int (*original_{index})(void *, void *);
int {name}(void *solver, void *system) {{ return judged(original_{index}(solver, system)); }}
"""
SOURCE = f"""\
static __thread int failures;
int given_up;
static int judged(int flag) {{
  if (flag != {_INDEFINITE} && flag != {_NOT_FULL_RANK}) failures = 0;
  else if (++failures > {MOST}) {{ failures = 0; given_up++; return {_UNKNOWN}; }}
  return flag;
}}
""" + "".join(_ONE.format(index=index, name=name) for index, name in enumerate(NAMES))


@lru_cache(maxsize=1)
def load_guard(compiler: Compiler) -> ctypes.CDLL | None:
    """Have Fatrop use it from now on; None if it will not.

    The library's `given_up` counts the solves that it ended.
    """
    if not sys.platform.startswith("linux"):  # elsewhere names belong to libraries
        return None
    found = sorted(Path(ca.__file__).parent.glob("libfatrop.so*"))
    if not found:
        return None
    try:
        path = str(compiled_library(compiler, SOURCE))
        # In front of Fatrop's only when it knows both of them: it calls nothing that is not there.
        guard = ctypes.CDLL(path, mode=os.RTLD_LOCAL)
        original = ctypes.CDLL(str(found[-1]), mode=os.RTLD_LAZY | os.RTLD_LOCAL)
        for index, name in enumerate(NAMES):
            address = ctypes.cast(original[name], ctypes.c_void_p).value
            ctypes.c_void_p.in_dll(guard, f"original_{index}").value = address
        ctypes.CDLL(path, mode=os.RTLD_GLOBAL)
    except (OSError, AttributeError, subprocess.SubprocessError) as error:
        _log.info("going on without an end for Fatrop's search for a direction: %s", error)
        return None
    return guard
