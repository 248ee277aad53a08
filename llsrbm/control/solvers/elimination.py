"""A program without its fixed variables: legs in the air cost a solver nothing."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from llsrbm.control.solvers.program import Array, Qp

# What a row without free variables may be violated by: rounding of what the fixed ones contribute.
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Reduced:
    """What is left of a program.

    Attributes:
        problem: in the free variables alone; rows of C without any are left out.
        free: (f,) indices of the free variables.
        fixed_at: (n,) the variables' values where they are fixed, 0 elsewhere.
        hopeless: no solver needs to look at it: a row that was left out cannot hold, limits exclude
            each other, or a number is none.
    """

    problem: Qp
    free: NDArray[np.intp]
    fixed_at: Array
    hopeless: bool

    def expand(self, x: Array) -> Array:
        """All variables, (n,), from the free ones, (f,)."""
        whole = self.fixed_at.copy()
        whole[self.free] = x
        return whole


def without_fixed(problem: Qp) -> Reduced:
    """Eliminate the variables whose bounds are equal."""
    p = problem
    is_fixed = p.x_lower == p.x_upper
    fixed_at = np.where(is_fixed, p.x_lower, 0.0)
    if not is_fixed.any():
        return Reduced(p, np.arange(len(is_fixed)), fixed_at, hopeless=not _sound(p))
    free = np.flatnonzero(~is_fixed)
    # `take` is several times faster than indexing with arrays.
    C = p.C.take(free, axis=1)
    kept = C.any(axis=1)
    H, A = p.H.take(free, axis=0).take(free, axis=1), p.A.take(free, axis=1)
    g, b, lower, upper = p.g[free], p.b, p.lower, p.upper
    if fixed_at.any():
        g = g + (p.H @ fixed_at)[free]
        b = b - p.A @ fixed_at
        share = p.C @ fixed_at
        lower, upper = lower - share, upper - share
    possible = kept | ((lower <= _ROUNDING) & (upper >= -_ROUNDING))
    left = Qp(H, g, A, b, C[kept], lower[kept], upper[kept], p.x_lower[free], p.x_upper[free])
    satisfied = len(free) > 0 or bool((np.abs(b) <= _ROUNDING).all())
    hopeless = not (satisfied and possible.all() and _sound(left))
    return Reduced(left, free, fixed_at, hopeless)


def _sound(p: Qp) -> bool:
    """Whether all numbers are finite, bounds aside, and no limits exclude each other.

    Solvers would iterate on NaN for seconds, and call it a solution.
    """
    total = p.H.sum() + p.g.sum() + p.A.sum() + p.b.sum() + p.C.sum()
    return bool(isfinite(total) and (p.lower <= p.upper).all() and (p.x_lower <= p.x_upper).all())
