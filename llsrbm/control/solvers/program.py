"""A convex quadratic program of the controller."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass
class Qp:
    """min 1/2 x'Hx + g'x  subject to  A x = b,  lower <= C x <= upper.

    The arrays are written in place by the caller, tick by tick; a solver keeps none of them.
    Limits may be ±inf.

    Attributes:
        H, g: (n, n) symmetric and positive definite, (n,).
        A, b: (e, n), (e,) equalities.
        C, lower, upper: (m, n), (m,), (m,) inequalities.
    """

    H: Array
    g: Array
    A: Array
    b: Array
    C: Array
    lower: Array
    upper: Array

    @classmethod
    def zeros(cls, variables: int, equalities: int, inequalities: int) -> Qp:
        """A program of that size, to be filled in: all zero, without any limit."""
        return cls(
            H=np.zeros((variables, variables)),
            g=np.zeros(variables),
            A=np.zeros((equalities, variables)),
            b=np.zeros(equalities),
            C=np.zeros((inequalities, variables)),
            lower=np.full(inequalities, -np.inf),
            upper=np.full(inequalities, np.inf),
        )

    @property
    def is_sound(self) -> bool:
        """Whether all numbers are finite, limits aside, and no limits exclude each other.

        Solvers would iterate on NaN for seconds, and call it a solution.
        """
        total = self.H.sum() + self.g.sum() + self.A.sum() + self.b.sum() + self.C.sum()
        return isfinite(total) and bool((self.lower <= self.upper).all())
