"""ProxQP (proximal augmented Lagrangian), started from the solution of the tick before."""

from __future__ import annotations

import numpy as np
from proxsuite import proxqp  # type: ignore[import-untyped]

from llsrbm.control.solvers.base import Qp, QpSolution, QpSolver

# Residual of the constraints and of the optimality conditions, absolute: N and m/s2 here. Tighter
# ones cost time and do not change a torque by more than the model is wrong.
TOLERANCE = 1e-4
# A solve from the tick before takes 1-5 iterations; what takes more than this is given up so that
# a tick cannot take arbitrarily long.
MAX_ITERATIONS = 100


class ProxQp(QpSolver):
    """The default: fastest at the median, exact to its tolerance."""

    name = "proxqp"
    summary = "proximal augmented Lagrangian with warm start (the default)"

    def __init__(self, variables: int, equalities: int, inequalities: int) -> None:
        super().__init__(variables, equalities, inequalities)
        self._start_afresh()

    def solve(self, problem: Qp) -> QpSolution:
        """See `QpSolver.solve`."""
        warm = self._warm
        solution = self._attempt(problem)
        if not solution.solved and warm:
            # The previous solution, or the penalties that go with it, may be a bad start after a
            # change of contacts.
            self._start_afresh()
            solution = self._attempt(problem)
        if not solution.solved:
            self._start_afresh()
        return solution

    def _start_afresh(self) -> None:
        self._qp = proxqp.dense.QP(
            self.variables, self.equalities, self.inequalities, box_constraints=True
        )
        settings = self._qp.settings
        settings.eps_abs, settings.eps_rel = TOLERANCE, 0.0
        settings.max_iter = MAX_ITERATIONS
        settings.initial_guess = proxqp.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT
        self._warm = False

    def _attempt(self, problem: Qp) -> QpSolution:
        p = problem
        data = (p.H, p.g, p.A, p.b, p.C, p.lower, p.upper, p.x_lower, p.x_upper)
        if self._warm:
            self._qp.update(*data)
        else:
            self._qp.init(*data)
        self._qp.solve()
        self._warm = True
        results = self._qp.results
        x = np.array(results.x)
        solved = results.info.status == proxqp.QPSolverOutput.PROXQP_SOLVED
        return QpSolution(x, bool(solved and np.isfinite(x).all()))
