"""quadprog (Goldfarb and Idnani's dual active-set method): exact."""

from __future__ import annotations

import numpy as np
import quadprog

from llsrbm.control.solvers.base import QpSolver
from llsrbm.control.solvers.program import Array, Qp


class Quadprog(QpSolver):
    """Exact, and the same to the last bit wherever and whenever it runs."""

    name = "quadprog"
    summary = "dual active-set method; exact, repeatable bit by bit (the default)"

    def _solve(self, p: Qp) -> Array | None:
        rows, right = _one_sided(p)
        # quadprog wants the transpose, column-major: rows are its columns.
        constraints = (rows.T, right, len(p.b)) if len(right) else ()
        try:
            return np.asarray(quadprog.solve_qp(p.H, -p.g, *constraints)[0])
        except ValueError:  # infeasible, or H is not positive definite
            return None


def _one_sided(p: Qp) -> tuple[Array, Array]:
    """Rows and right sides: A x = b, then every finite limit as rows @ x >= right."""
    low, up = np.isfinite(p.lower), np.isfinite(p.upper)
    rows = np.concatenate((p.A, p.C[low], -p.C[up]))
    return rows, np.concatenate((p.b, p.lower[low], -p.upper[up]))
