"""The numbers of one problem for a solver, and its solution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Problem:
    """The numbers of one request; the expressions are those of a `Transcription`.

    Attributes:
        parameters: (n,), shared by all stages.
        lower, upper: (rows,) bounds of g: of each stage its gap to the next, zeros, and its rows.
    """

    parameters: Array
    lower: Array
    upper: Array


@dataclass(frozen=True, eq=False)
class Iterate:
    """A point in a solver's own order and units: where a next solve may start.

    Attributes:
        variables: (n,), stage after stage, states before controls.
        multipliers: (rows,) of g.
    """

    variables: Array
    multipliers: Array


@dataclass(frozen=True, eq=False)
class Solution(Iterate):
    """Where a solve ended, and how it got there.

    Attributes:
        converged: as the solver reports.
        iterations, cost, solve_time_s: of this solve.
        violation: the largest of a row, in their units of about 1.
        message: the solver's status.
    """

    converged: bool
    iterations: int
    cost: float
    solve_time_s: float
    violation: float
    message: str
