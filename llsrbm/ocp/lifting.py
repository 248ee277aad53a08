"""First and second derivatives through marked intermediate quantities, exactly.

With the intermediates y_k = f_k(z, y_1 ... y_{k-1}) marked, the chain rule runs over small sparse
blocks, from the last intermediate to the first (edge pushing); `llsrbm.ocp` says why:

    H <- H_rr + J^T H_yr + H_ry J + J^T H_yy J + sum_j ybar_j d2 f_j,   ybar_r <- ybar_r + J^T ybar
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import casadi as ca


class Lifting:
    """Collects intermediates; call it with an expression to get the symbol that stands for it."""

    def __init__(self, variables: ca.SX) -> None:
        """Args: variables: z, (n, 1), all symbols that derivatives are taken with respect to."""
        self.variables = variables
        self._symbols: list[ca.SX] = []
        self._definitions: list[ca.SX] = []

    def __call__(self, expression: Any) -> Any:
        """Mark `expression`, any shape; the returned symbols have the same shape."""
        symbol = ca.SX.sym(f"y{len(self._symbols)}", *expression.shape)
        self._symbols.append(ca.vec(symbol))
        self._definitions.append(ca.densify(ca.vec(ca.SX(expression))))
        return symbol

    @property
    def marked(self) -> tuple[list[ca.SX], list[ca.SX]]:
        """Symbols of the intermediates, and what each stands for."""
        return self._symbols, self._definitions

    def resolve(self, expression: ca.SX) -> ca.SX:
        """`expression` in terms of z and parameters alone."""
        if not self._symbols:
            return expression
        # In one sweep: one intermediate after the other would walk through all of it each time.
        _, (resolved,) = ca.substitute_inplace(self._symbols, self._definitions, [expression])
        return resolved

    def jacobian(self, outputs: ca.SX) -> ca.SX:
        """d outputs / dz, unresolved (it may contain the intermediates' symbols)."""
        A = ca.jacobian(outputs, self._everything)
        for _, definition, before in self._last_to_first():
            rest = before.shape[0]
            left = ca.sparsify(A[:, rest:])
            A = A[:, :rest]
            if left.nnz():
                A = A + ca.mtimes(left, ca.jacobian(definition, before))
        return A

    def hessian(self, scalar: ca.SX) -> ca.SX:
        """d2 scalar / dz2, unresolved, symmetric with both triangles filled."""
        gradient = ca.gradient(scalar, self._everything)
        H = _symmetric(ca.jacobian(gradient, self._everything))
        for symbol, definition, before in self._last_to_first():
            rest = before.shape[0]
            J = ca.jacobian(definition, before)
            ybar = gradient[rest:]
            half = ca.mtimes(J.T, H[rest:, :rest] + ca.mtimes(H[rest:, rest:], J) / 2)
            # The definition's own curvature: ybar enters as a constant.
            adjoint = ca.SX.sym("ybar", symbol.shape[0])
            slope = ca.jtimes(definition, before, adjoint, True)
            curvature = ca.substitute(ca.jacobian(slope, before), adjoint, ybar)
            H = _symmetric(H[:rest, :rest] + half + half.T + curvature)
            gradient = gradient[:rest] + ca.mtimes(J.T, ybar)
        return H

    @property
    def _everything(self) -> ca.SX:
        return ca.vertcat(self.variables, *self._symbols)

    def _last_to_first(self) -> Iterator[tuple[ca.SX, ca.SX, ca.SX]]:
        """Symbol, definition and all symbols before it, of each intermediate."""
        for k in reversed(range(len(self._symbols))):
            before = ca.vertcat(self.variables, *self._symbols[:k])
            yield self._symbols[k], self._definitions[k], before


def _symmetric(H: ca.SX) -> ca.SX:
    """The upper triangle twice: the lower one is the same nodes, so it is computed once."""
    return ca.sparsify(ca.triu2symm(ca.triu(H)))
