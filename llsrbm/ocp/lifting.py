"""Marks intermediate quantities of an expression, for derivatives to run through them."""

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
