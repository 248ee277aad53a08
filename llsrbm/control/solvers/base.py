"""What a solver of the controller's quadratic program has to offer."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from llsrbm.control.solvers.elimination import without_fixed
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
    """Solves programs of one size, one after the other."""

    name: ClassVar[str]
    summary: ClassVar[str]

    def __init__(self, variables: int, equalities: int, inequalities: int) -> None:
        self.variables, self.equalities, self.inequalities = variables, equalities, inequalities

    def solve(self, problem: Qp) -> QpSolution:
        """Solve one program; whatever goes wrong numerically ends in `solved=False`."""
        reduced = without_fixed(problem)
        if reduced.hopeless:
            return QpSolution(reduced.fixed_at, solved=False)
        x = self._solve(reduced.problem) if len(reduced.free) else np.zeros(0)
        if x is None or not np.isfinite(x).all():
            return QpSolution(reduced.fixed_at, solved=False)
        return QpSolution(reduced.expand(x), solved=True)

    @abstractmethod
    def _solve(self, p: Qp) -> Array | None:
        """Solve a program with at least one variable, none of them fixed; None: not solved."""
