"""quadprog (Goldfarb and Idnani's dual active-set method): exact."""

from __future__ import annotations

import numpy as np
import quadprog

from llsrbm.control.solvers.base import QpSolver
from llsrbm.control.solvers.program import Array, Qp


class Quadprog(QpSolver):
    """Exact, and the same to the last bit wherever and whenever it runs.

    It has no bounds of variables: they become rows.
    """

    name = "quadprog"
    summary = "dual active-set method; exact, repeatable bit by bit (the default)"

    def _solve(self, p: Qp) -> Array | None:
        rows, right = _one_sided(p)
        constraints = (rows.T, right, len(p.b)) if len(right) else ()
        try:
            return np.asarray(quadprog.solve_qp(p.H, -p.g, *constraints)[0])
        except ValueError:  # infeasible, or H is not positive definite
            return None


def _one_sided(p: Qp) -> tuple[Array, Array]:
    """Rows and right sides: A x = b, then every finite bound as rows @ x >= right."""
    low, up = np.isfinite(p.lower), np.isfinite(p.upper)
    x_low, x_up = np.flatnonzero(np.isfinite(p.x_lower)), np.flatnonzero(np.isfinite(p.x_upper))
    right = np.concatenate((p.b, p.lower[low], -p.upper[up], p.x_lower[x_low], -p.x_upper[x_up]))
    # quadprog wants the transpose, column-major: these are its columns.
    rows = np.zeros((len(right), len(p.g)))
    at = len(p.b)
    rows[:at] = p.A
    for part in (p.C[low], -p.C[up]):
        rows[at : at + len(part)] = part
        at += len(part)
    for columns, sign in ((x_low, 1.0), (x_up, -1.0)):
        rows[np.arange(at, at + len(columns)), columns] = sign
        at += len(columns)
    return rows, right
