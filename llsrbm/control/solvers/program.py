"""A convex quadratic program of the controller."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass
class Qp:
    """min 1/2 x'Hx + g'x  subject to  A x = b,  lower <= C x <= upper,  x_lower <= x <= x_upper.

    The arrays are written in place by the caller, tick by tick; a solver keeps none of them.
    Bounds may be ±inf; x_lower == x_upper fixes a variable.

    Attributes:
        H, g: (n, n) symmetric and positive definite, (n,).
        A, b: (e, n), (e,) equalities.
        C, lower, upper: (m, n), (m,), (m,) inequalities.
        x_lower, x_upper: (n,), (n,).
    """

    H: Array
    g: Array
    A: Array
    b: Array
    C: Array
    lower: Array
    upper: Array
    x_lower: Array
    x_upper: Array

    @classmethod
    def zeros(cls, variables: int, equalities: int, inequalities: int) -> Qp:
        """A program of that size, to be filled in: all zero, without any bound."""
        return cls(
            H=np.zeros((variables, variables)),
            g=np.zeros(variables),
            A=np.zeros((equalities, variables)),
            b=np.zeros(equalities),
            C=np.zeros((inequalities, variables)),
            lower=np.full(inequalities, -np.inf),
            upper=np.full(inequalities, np.inf),
            x_lower=np.full(variables, -np.inf),
            x_upper=np.full(variables, np.inf),
        )
