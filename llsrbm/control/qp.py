"""The controller's quadratic program, solved by linear equations where they do, or by quadprog.

quadprog is Goldfarb and Idnani's dual active-set method: exact, and the same to the last bit
wherever and whenever it runs.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

import numpy as np
import quadprog
from scipy.linalg.lapack import dposv

from llsrbm.arrays import Array, BoolArray
from llsrbm.request.messages import look_up

SOFTNESS = 1e4
"""Weight of a soft bound, as a contact's: above all tasks, (m/s2)^-2 or (rad/s2)^-2."""
_ROUNDS = 6


@dataclass
class Qp:
    """min 1/2 x'Hx + g'x + w/2 |outside|^2  subject to  A x = b,  lower <= C x <= upper.

    `outside`: by how much x is below `soft_lower` or above `soft_upper`, and `soft_rows` x below
    `soft_least`; w is `SOFTNESS`. As slacks these can never make the program infeasible.
    The arrays are written in place by the caller, tick by tick; a solver keeps none of them.
    Limits may be ±inf.
    """

    H: Array  # (n, n) symmetric and positive definite, (n,)
    g: Array  # (n, n) symmetric and positive definite, (n,)
    A: Array  # (e, n), (e,) equalities
    b: Array  # (e, n), (e,) equalities
    C: Array  # (m, n), (m,), (m,) inequalities
    lower: Array  # (m, n), (m,), (m,) inequalities
    upper: Array  # (m, n), (m,), (m,) inequalities
    soft_lower: Array  # (n,)
    soft_upper: Array  # (n,)
    soft_rows: Array  # (k, n), (k,)
    soft_least: Array  # (k, n), (k,)

    @classmethod
    def zeros(cls, variables: int, equalities: int, inequalities: int) -> Qp:
        """A program of that size, to be filled in: all zero, without any limit."""
        return cls(
            H=np.zeros((variables, variables)),
            g=np.zeros(variables),
            A=np.zeros((equalities, variables)),
            b=np.zeros(equalities),
            C=np.zeros((inequalities, variables)),
            lower=np.full(inequalities, -np.inf),
            upper=np.full(inequalities, np.inf),
            soft_lower=np.full(variables, -np.inf),
            soft_upper=np.full(variables, np.inf),
            soft_rows=np.zeros((0, variables)),
            soft_least=np.zeros(0),
        )

    @property
    def is_sound(self) -> bool:
        """True if all numbers are finite, limits aside, and no limits exclude each other."""
        total = self.H.sum() + self.g.sum() + self.A.sum() + self.b.sum() + self.C.sum()
        return isfinite(total) and bool((self.lower <= self.upper).all())

    def solve(self) -> Array | None:
        """(n,) the solution; None where there is none, or for numeric reasons none is found.

        In nine of ten ticks no inequality is active: the minimum under the equalities is the
        solution. Soft bounds that it oversteps are pulled at, until they are those that the
        minimum of the pulled program oversteps: Newton's method on a piecewise quadratic cost.
        """
        x = self._under_hard_limits(self.H, self.g)
        pulled: BoolArray = np.zeros(len(self.g) + len(self.soft_least), dtype=bool)
        for _ in range(_ROUNDS):
            if x is None:
                return None
            low, up = x < self.soft_lower, x > self.soft_upper
            short = self.soft_rows @ x < self.soft_least
            outside = np.concatenate((low | up, short))
            if (outside == pulled).all():
                break
            pulled, rows = outside, self.soft_rows[short]
            H = self.H + SOFTNESS * (rows.T @ rows)
            H.reshape(-1)[:: len(x) + 1] += SOFTNESS * (low | up)
            bound = np.where(low, self.soft_lower, np.where(up, self.soft_upper, 0.0))
            bound += self.soft_least[short] @ rows
            x = self._under_hard_limits(H, self.g - SOFTNESS * bound)
        return x

    def _under_hard_limits(self, H: Array, g: Array) -> Array | None:
        x = self._under_equalities(H, g)
        if x is None and self.is_sound:
            x = self._by_active_sets(H, g)
        return x if x is not None and np.isfinite(x).all() else None

    def _by_active_sets(self, H: Array, g: Array) -> Array | None:
        # Rows and right sides: A x = b, then every finite limit as rows @ x >= right.
        low, up = np.isfinite(self.lower), np.isfinite(self.upper)
        rows = np.concatenate((self.A, self.C[low], -self.C[up]))
        right = np.concatenate((self.b, self.lower[low], -self.upper[up]))
        # quadprog wants the transpose, column-major: rows are its columns.
        constraints = (rows.T, right, len(self.b)) if len(right) else ()
        try:
            return np.asarray(quadprog.solve_qp(H, -g, *constraints)[0])
        except ValueError:  # infeasible, or H is not positive definite
            return None

    def _under_equalities(self, H: Array, g: Array) -> Array | None:
        """x = H^-1 (A' multipliers - g), (n,), where it keeps the inequalities; None otherwise."""
        equalities = len(self.b)
        right = np.empty((len(g), equalities + 1), order="F")
        right[:, :-1] = self.A.T
        np.negative(g, out=right[:, -1])
        _, free, failed = dposv(H.T, right)
        if failed or not np.isfinite(free).all():
            return None
        x: Array = free[:, -1]
        if equalities:
            _, multipliers, failed = dposv(self.A.dot(free[:, :-1]), self.b - self.A.dot(x))
            if failed or not np.isfinite(multipliers).all():
                return None
            x = x + free[:, :-1].dot(multipliers)
        at = self.C.dot(x)  # comparisons with what is no number are false
        return x if (at >= self.lower).all() and (at <= self.upper).all() else None


def check_name(name: str) -> None:
    """Raise `InputError` for a name that is not the QP solver's."""
    gone = (
        "as proxqp, which solved the same programs less exactly, is gone"
        if name == "proxqp"
        else ""
    )
    look_up("QP solver", name, {"quadprog": Qp.solve}, gone)
