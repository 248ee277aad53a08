"""quadprog (Goldfarb and Idnani's dual active-set method): exact, and started afresh every tick."""

from __future__ import annotations

import numpy as np
import quadprog  # type: ignore[import-not-found]

from llsrbm.control.solvers.base import Array, Qp, QpSolution, QpSolver

# What a row without free variables may be violated by: rounding of what the fixed ones contribute.
_ROUNDING = 1e-9


class Quadprog(QpSolver):
    """The alternative: exact, and its time varies little.

    It has no bounds of variables: fixed variables are eliminated, other bounds become rows.
    """

    name = "quadprog"
    summary = "dual active-set method, exact"

    def solve(self, problem: Qp) -> QpSolution:
        """See `QpSolver.solve`."""
        p = problem
        x = p.x_lower.copy()
        free = np.flatnonzero(p.x_lower != p.x_upper)
        H, g, A, b, C = p.H, p.g, p.A, p.b, p.C
        lower, upper = p.lower, p.upper
        if len(free) < len(x):
            fixed = np.flatnonzero(p.x_lower == p.x_upper)
            H, g = p.H[np.ix_(free, free)], p.g[free]
            A, C = p.A[:, free], p.C[:, free]
            if x[fixed].any():
                g = g + p.H[np.ix_(free, fixed)] @ x[fixed]
                b = b - p.A[:, fixed] @ x[fixed]
                share = p.C[:, fixed] @ x[fixed]
                lower, upper = lower - share, upper - share
            # quadprog divides by the norm of a row.
            rows = C.any(axis=1)
            if (lower[~rows] > _ROUNDING).any() or (upper[~rows] < -_ROUNDING).any():
                return QpSolution(x, solved=False)
            C, lower, upper = C[rows], lower[rows], upper[rows]
        stacked, right = _one_sided(
            A, b, C, lower, upper, p.x_lower[free], p.x_upper[free], len(free)
        )
        try:
            found = quadprog.solve_qp(H, -g, stacked.T, right, len(b))[0]
        except ValueError:  # infeasible, or H is not positive definite
            return QpSolution(x, solved=False)
        x[free] = found
        return QpSolution(x, bool(np.isfinite(x).all()))


def _one_sided(
    A: Array,
    b: Array,
    C: Array,
    lower: Array,
    upper: Array,
    x_lower: Array,
    x_upper: Array,
    variables: int,
) -> tuple[Array, Array]:
    """Rows and right sides of A x = b and then of every finite bound, as rows @ x >= right."""
    low, up = np.isfinite(lower), np.isfinite(upper)
    x_low, x_up = np.flatnonzero(np.isfinite(x_lower)), np.flatnonzero(np.isfinite(x_upper))
    right = np.concatenate((b, lower[low], -upper[up], x_lower[x_low], -x_upper[x_up]))
    rows = np.zeros((len(right), variables))
    at = len(b)
    rows[:at] = A
    for part in (C[low], -C[up]):
        rows[at : at + len(part)] = part
        at += len(part)
    for columns, sign in ((x_low, 1.0), (x_up, -1.0)):
        rows[np.arange(at, at + len(columns)), columns] = sign
        at += len(columns)
    return rows, right
