"""The product of small matrices that Fatrop spends its time in, for this machine's processor.

Fatrop's linear algebra is BLASFEO, whose kernels are written for each processor; CasADi's wheels
carry the one for none in particular, and its product of two 4 x 4 blocks is half of a compiled
solve. The linker takes the first definition of a name: one compiled here, if it is loaded before
Fatrop is. It is used where it computes what the original does.
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
import numpy as np

from llsrbm.ocp.compiled import Compiler
from llsrbm.ocp.small_library import compiled_library

_log = logging.getLogger(__name__)

NAME = "kernel_dgemm_nt_4x4_lib4"
# Kernels that builds for a certain processor have, and the general one has not.
_SPECIAL = ("kernel_dgemm_nt_8x4_lib4", "kernel_dgemm_nt_12x4_lib4")

# D = beta C + alpha A B^T; blocks have their columns one behind the other. Two sums, of even and of
# odd k, so that one need not wait for the other.
SOURCE = f"""\
typedef double four __attribute__((vector_size(32)));
typedef double at __attribute__((vector_size(32), aligned(8)));
void {NAME}(int n, double *alpha, double *A, double *B, double *beta, double *C, double *D) {{
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


@lru_cache(maxsize=1)
def load_kernel(compiler: Compiler) -> bool:
    """Have Fatrop use it from now on, if it has not been loaded yet; whether it will."""
    if not sys.platform.startswith("linux"):  # elsewhere names belong to libraries
        return False
    blasfeo = next(iter(sorted(Path(ca.__file__).parent.glob("libblasfeo.so*"))), None)
    if blasfeo is None:
        return False
    try:
        # Without its own names first, as CasADi would load it.
        original = ctypes.CDLL(str(blasfeo), mode=os.RTLD_LAZY | os.RTLD_LOCAL)
        if not hasattr(original, NAME) or any(hasattr(original, name) for name in _SPECIAL):
            return False
        path = compiled_library(compiler, SOURCE)
        if not _same(original, ctypes.CDLL(str(path), mode=os.RTLD_LOCAL)):
            _log.warning("BLASFEO's kernel is another one than expected; it stays")
            return False
        ctypes.CDLL(str(path), mode=os.RTLD_GLOBAL)
    except (OSError, subprocess.SubprocessError) as error:
        _log.info("going on with BLASFEO's own kernel: %s", error)
        return False
    return True


def product(
    library: ctypes.CDLL, alpha: float, A: np.ndarray, B: np.ndarray, beta: float, C: np.ndarray
) -> np.ndarray:
    """(4, 4) beta C + alpha A B^T by a library's kernel; A and B (4, n), C (4, 4)."""

    def pointer(array: np.ndarray) -> ctypes.c_void_p:
        return ctypes.c_void_p(array.ctypes.data)

    # BLASFEO aligns its matrices to 64 bytes; kernels that load pairs of numbers need 16.
    A, B, C, D = (_aligned(array.T) for array in (A, B, C, np.zeros((4, 4))))
    scalars = np.array([alpha]), np.array([beta])
    getattr(library, NAME)(
        len(A), pointer(scalars[0]), *map(pointer, (A, B)), *map(pointer, (scalars[1], C, D))
    )
    return D.T.copy()


def _aligned(array: np.ndarray) -> np.ndarray:
    room = np.zeros(array.size + 8)
    start = (-room.ctypes.data // 8) % 8
    found = room[start : start + array.size].reshape(array.shape)
    found[:] = array
    return found


def _same(one: ctypes.CDLL, other: ctypes.CDLL) -> bool:
    """Whether two libraries' kernels compute the same."""
    rng = np.random.default_rng(0)
    for n in range(10):
        for alpha, beta in ((1.0, 1.0), (-1.0, 1.0), (1.0, 0.0), (0.7, -0.3)):
            A, B, C = rng.normal(size=(4, n)), rng.normal(size=(4, n)), rng.normal(size=(4, 4))
            a, b = (product(library, alpha, A, B, beta, C) for library in (one, other))
            if not np.allclose(a, b, rtol=_TOLERANCE, atol=_TOLERANCE):
                return False
    return True
