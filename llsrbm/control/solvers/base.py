"""What a solver of the controller's quadratic program has to offer."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.linalg.lapack import dposv

from llsrbm.control.solvers.program import Array, Qp


@dataclass(frozen=True, eq=False)
class QpSolution:
    """Where a solver stopped.

    Attributes:
        x: (n,) the caller's to keep; meaningless unless solved.
        solved: whether x is feasible and optimal within the solver's tolerance.
    """

    x: Array
    solved: bool


class QpSolver(ABC):
    """Solves programs, one after the other; their sizes may change.

    In nine of ten ticks no inequality is active: where the minimum under the equalities alone keeps
    them all, it is the solution, and no solver needs to look for it.
    """

    name: ClassVar[str]
    summary: ClassVar[str]

    def solve(self, problem: Qp) -> QpSolution:
        """Solve one program; whatever goes wrong numerically ends in `solved=False`."""
        x = _under_equalities(problem)
        if x is not None:
            return QpSolution(x, solved=True)
        x = self._solve(problem) if problem.is_sound else None
        if x is None or not np.isfinite(x).all():
            return QpSolution(np.zeros_like(problem.g), solved=False)
        return QpSolution(x, solved=True)

    @abstractmethod
    def _solve(self, p: Qp) -> Array | None:
        """Solve a program whose numbers are finite; None: not solved."""


def _under_equalities(p: Qp) -> Array | None:
    """The minimum under the equalities, (n,), where it keeps the inequalities; None otherwise.

    From x = H^-1 (A' multipliers - g), which the equalities give a linear system for.
    """
    equalities = len(p.b)
    right = np.empty((len(p.g), equalities + 1), order="F")
    right[:, :-1] = p.A.T
    np.negative(p.g, out=right[:, -1])
    _, free, failed = dposv(p.H.T, right)
    if failed or not np.isfinite(free).all():
        return None
    x: Array = free[:, -1]
    if equalities:
        _, multipliers, failed = dposv(p.A.dot(free[:, :-1]), p.b - p.A.dot(x))
        if failed or not np.isfinite(multipliers).all():
            return None
        x = x + free[:, :-1].dot(multipliers)
    at = p.C.dot(x)  # comparisons with what is no number are false
    return x if (at >= p.lower).all() and (at <= p.upper).all() else None
