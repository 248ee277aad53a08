"""ProxQP (proximal augmented Lagrangian), each solve started from the equality-constrained optimum.

That start needs no more iterations here than the solution of the tick before, and it cannot be
spoilt by it: with warm starts, penalties that a hard tick had driven up stayed, and made later,
easy ticks slow or "infeasible".
"""

from __future__ import annotations

import numpy as np
from proxsuite import proxqp

from llsrbm.control.solvers.base import QpSolver
from llsrbm.control.solvers.program import Array, Qp

# Residual of the constraints and of the optimality conditions, absolute: N, Nm and m/s2 here.
# Torques then agree with exact ones to 1e-3 Nm; 1e-4 is hardly faster, 1e-6 costs 15 % more.
TOLERANCE = 1e-5
# Without a limit on the gap between primal and dual cost, a limit with a large multiplier may be
# missed by far; a smaller one costs an iteration.
DUALITY_GAP = 1e-3
# What its certificates of infeasibility must be exact to; with the library's 1e-4 it gives up
# programs whose feasible set is thin. MAX_ITERATIONS ends what is truly infeasible.
INFEASIBLE = 1e-12
# A tick takes 1-7 iterations and 35 when most limits are active; one that takes more is lost, and
# shall not delay the next ones.
MAX_ITERATIONS = 100
# Penalties at the start, ten times tighter than the library's: fewer updates, fewer iterations.
MU_EQUALITY, MU_INEQUALITY = 1e-4, 1e-2


class ProxQp(QpSolver):
    """Some 10 % slower than quadprog where limits are active, exact to its tolerance.

    Its last bits depend on where in memory its matrices lie: not for runs that shall repeat bit by
    bit.
    """

    name = "proxqp"
    summary = "proximal augmented Lagrangian; exact to a tolerance"

    def __init__(self) -> None:
        # A library object, with the scaling of its first program, for each size met.
        self._qps: dict[tuple[int, int, int], proxqp.dense.QP] = {}

    def _solve(self, p: Qp) -> Array | None:
        size = (len(p.g), len(p.b), len(p.lower))
        # A second attempt has a scaling of its own, for programs unlike the first of that size.
        for _ in range(2 if size in self._qps else 1):
            x = self._attempt(p, size)
            if x is not None:
                return x
            self._qps.pop(size)
        return None

    def _attempt(self, p: Qp, size: tuple[int, int, int]) -> Array | None:
        data = (p.H, p.g, p.A, p.b, p.C, p.lower, p.upper)
        qp = self._qps.get(size)
        if qp is None:
            qp = proxqp.dense.QP(*size)
            settings = qp.settings
            settings.eps_abs, settings.eps_rel = TOLERANCE, 0.0
            settings.check_duality_gap = True
            settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = DUALITY_GAP, 0.0
            settings.eps_primal_inf = settings.eps_dual_inf = INFEASIBLE
            settings.max_iter = MAX_ITERATIONS
            settings.initial_guess = proxqp.InitialGuess.EQUALITY_CONSTRAINED_INITIAL_GUESS
            qp.init(*data, mu_eq=MU_EQUALITY, mu_in=MU_INEQUALITY)
            self._qps[size] = qp
        else:
            qp.update(*data)
        qp.solve()
        solved = qp.results.info.status == proxqp.QPSolverOutput.PROXQP_SOLVED
        return np.array(qp.results.x) if solved else None
