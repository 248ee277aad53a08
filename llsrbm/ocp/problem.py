"""The numbers of one problem for a solver, and its solution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Problem:
    """The numbers of one request; the expressions are those of a `Transcription`."""

    parameters: Array  # (n,), shared by all stages
    lower: Array  # (rows,) bounds of g: of each stage its gap to the next, zeros, and its rows
    upper: Array  # (rows,) bounds of g: of each stage its gap to the next, zeros, and its rows


@dataclass(frozen=True, eq=False)
class Iterate:
    """A point in a solver's own order and units: where a next solve may start."""

    variables: Array  # (n,), stage after stage, states before controls
    multipliers: Array  # (rows,) of g


@dataclass(frozen=True, eq=False)
class Solution(Iterate):
    """Where a solve ended, and how it got there."""

    converged: bool  # as the solver reports
    iterations: int  # of this solve
    cost: float  # of this solve
    solve_time_s: float  # of this solve
    violation: float  # the largest of a row, in their units of about 1
    message: str  # the solver's status
