"""First and second derivatives through marked intermediate quantities, exactly.

An interval's expressions are deep: foot positions, the base offset, leg CoMs and momenta are
functions of each other. Differentiating the flattened expression costs one sweep through all of it
a variable. With the intermediates y_k = f_k(z, y_1 ... y_{k-1}) marked, the chain rule runs over
small sparse blocks instead, from the last intermediate to the first (edge pushing):

    H <- H_rr + J^T H_yr + H_ry J + J^T H_yy J + sum_j ybar_j d2 f_j,   ybar_r <- ybar_r + J^T ybar
"""

from __future__ import annotations

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
        self._definitions.append(ca.vec(ca.SX(expression)))
        return symbol

    def resolve(self, expression: ca.SX) -> ca.SX:
        """`expression` in terms of z and parameters alone."""
        for symbol, definition in reversed(list(zip(self._symbols, self._definitions, strict=True))):
            expression = ca.substitute(expression, symbol, definition)
        return expression

    def jacobian(self, outputs: ca.SX) -> ca.SX:
        """d outputs / dz, unresolved (it may contain the intermediates' symbols)."""
        total = ca.jacobian(outputs, self.variables)
        rates: list[ca.SX] = []
        for k, definition in enumerate(self._definitions):
            rate = ca.jacobian(definition, self.variables)
            for j in range(k):
                rate = _add_product(rate, ca.jacobian(definition, self._symbols[j]), rates[j])
            rates.append(rate)
            total = _add_product(total, ca.jacobian(outputs, self._symbols[k]), rate)
        return total

    def hessian(self, scalar: ca.SX) -> ca.SX:
        """d2 scalar / dz2, unresolved, symmetric with both triangles filled."""
        everything = ca.vertcat(self.variables, *self._symbols)
        gradient = ca.gradient(scalar, everything)
        H = ca.jacobian(gradient, everything)
        for symbol, definition in reversed(list(zip(self._symbols, self._definitions, strict=True))):
            rest = H.shape[0] - symbol.shape[0]
            before = everything[:rest]
            J = ca.jacobian(definition, before)
            ybar = gradient[rest:]
            H_ry, H_yy = H[:rest, rest:], H[rest:, rest:]
            half = ca.mtimes(J.T, H_ry.T + ca.mtimes(H_yy, J) / 2)
            # The definition's own curvature: ybar enters as a constant.
            adjoint = ca.SX.sym("ybar", symbol.shape[0])
            slope = ca.jtimes(definition, before, adjoint, True)
            curvature = ca.substitute(ca.jacobian(slope, before), adjoint, ybar)
            H = ca.sparsify(H[:rest, :rest] + half + half.T + curvature)
            gradient = gradient[:rest] + ca.mtimes(J.T, ybar)
        return H


def _add_product(total: ca.SX, left: ca.SX, right: ca.SX) -> ca.SX:
    return total if left.nnz() == 0 else total + ca.mtimes(left, right)
