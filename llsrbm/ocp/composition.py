"""A stage as functions of functions: each is derived once, wherever and however often it is called.

A stage's quantities w are its variables z and what functions y_k = f_k(w_k) give of those before,
w_k. With D_k = dw_k/dz the chain rule runs over whole functions, and its second order is a sum:

    dy_k/dz = J_k D_k,     H = sum_k D_k^T (sum_j ybar_kj d2 f_kj) D_k,

where ybar_k, the slope of the Lagrangian by y_k, comes from the last function to the first. So the
dynamics of a leg, called for each leg at each instant, are written and derived once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import casadi as ca

from llsrbm.abandon import go_on
from llsrbm.ocp.derivatives import Derivatives, nonzeros
from llsrbm.ocp.lifting import Lifting


class Derived:
    """A function y = f(v; n) of variables and numbers, with its exact derivatives by v.

    Attributes:
        value: (v, n) -> y; slope: (v, n) -> y and the non-zeros of dy/dv.
        bend: (v, n, ybar) -> the non-zeros of the Hessian of ybar . y by v.
        slope_pattern, bend_pattern: their sparsities.
    """

    def __init__(
        self, name: str, variables: ca.SX, numbers: ca.SX, output: ca.SX, lift: Lifting
    ) -> None:
        """`output`: expressions that may hold what `lift`, of these variables, has marked."""
        self.name = name
        output = ca.densify(ca.vec(output))
        inner = Derivatives(name, lift, [numbers], output)
        ybar = ca.SX.sym("ybar", output.shape[0])
        values, J = inner.jacobian(variables, numbers)
        H = inner.hessian(variables, numbers, ybar)
        self.slope_pattern, self.bend_pattern = J.sparsity(), H.sparsity()

        def function(kind: str, arguments: list[Any], results: list[Any]) -> ca.Function:
            go_on()
            return ca.Function(f"{name}_{kind}", arguments, results, {"cse": True})

        self.value = function("y", [variables, numbers], [ca.densify(lift.resolve(output))])
        self.slope = function("dy", [variables, numbers], [values, nonzeros(J)])
        self.bend = function("ddy", [variables, numbers, ybar], [nonzeros(H)])

    @property
    def width(self) -> int:
        """Number of variables."""
        return int(self.value.size1_in(0))

    @property
    def height(self) -> int:
        """Number of outputs."""
        return int(self.value.size1_out(0))


class Part(NamedTuple):
    """Neighbours among a stage's quantities: from `start` to `stop` of those of one function."""

    source: int  # 0: the stage's variables; k: the outputs of the k-th call
    start: int
    stop: int

    @property
    def size(self) -> int:
        """Number of quantities."""
        return self.stop - self.start

    def cut(self, start: int, stop: int) -> Part:
        """Some of them."""
        assert 0 <= start <= stop <= self.size
        return Part(self.source, self.start + start, self.start + stop)


class _Call(NamedTuple):
    function: Derived
    inputs: tuple[Part, ...]
    numbers: Any  # MX


@dataclass(eq=False)
class Composition:
    """Calls in the order in which they are made.

    Attributes:
        variables: (n, 1) MX, z; unit: (n, 1) MX or DM: what one of each is in SI units.
        numbers: (s, 1) MX, the stage's parameters.
    """

    variables: Any
    unit: Any
    numbers: Any
    calls: list[_Call] = field(default_factory=list)

    @property
    def start(self) -> Part:
        """The variables, in SI units."""
        return Part(0, 0, int(self.variables.shape[0]))

    def __call__(self, function: Derived, inputs: Sequence[Part], numbers: Any) -> Part:
        """The outputs of a function, given parts, one after the other, and numbers."""
        assert sum(part.size for part in inputs) == function.width, function.name
        self.calls.append(_Call(function, tuple(inputs), numbers))
        return Part(len(self.calls), 0, function.height)

    @cached_property
    def values(self) -> list[Any]:
        """MX of each source."""
        found = [self.unit * self.variables]
        for call in self.calls:
            found.append(call.function.value(_gathered(found, call.inputs), call.numbers))
        return found

    @cached_property
    def _slopes(self) -> tuple[list[Any], list[Any]]:
        """MX of each source, and of each call's J_k."""
        found, slopes = [self.unit * self.variables], []
        for function, inputs, numbers in self.calls:
            value, nonzeros = function.slope(_gathered(found, inputs), numbers)
            found.append(value)
            slopes.append(ca.MX(function.slope_pattern, nonzeros))
        return found, slopes

    @cached_property
    def _by_variables(self) -> tuple[list[Any], list[Any]]:
        """dw/dz of each source, and D_k of each call."""
        found, inward = [ca.diag(self.unit)], []
        for call, J in zip(self.calls, self._slopes[1], strict=True):
            inward.append(_gathered(found, call.inputs))
            found.append(ca.mtimes(J, inward[-1]))
        return found, inward

    def of(self, part: Part) -> Any:
        """(n, 1) MX, its values."""
        return self.values[part.source][part.start : part.stop]

    def jacobian(self, parts: Sequence[Part]) -> tuple[Any, Any]:
        """Values of parts, and their derivatives by the variables."""
        return _gathered(self._slopes[0], parts), _gathered(self._by_variables[0], parts)

    def _backward(self, slopes: Sequence[tuple[Part, Any]]) -> list[list[Any]]:
        """Slopes of a sum by each source, of its slopes by some parts, piece by piece."""
        by: list[list[Any]] = [[] for _ in range(len(self.calls) + 1)]
        sizes = [self.start.size, *(call.function.height for call in self.calls)]

        def add(part: Part, slope: Any) -> None:
            before, after = part.start, sizes[part.source] - part.stop
            by[part.source].append(ca.vertcat(ca.MX(before, 1), slope, ca.MX(after, 1)))

        for part, slope in slopes:
            add(part, slope)
        for k in reversed(range(len(self.calls))):
            if not by[k + 1]:
                continue
            total = by[k + 1][0] if len(by[k + 1]) == 1 else sum(by[k + 1][1:], by[k + 1][0])
            by[k + 1] = [ca.densify(total)]
            inward = ca.mtimes(self._slopes[1][k].T, by[k + 1][0])
            at = 0
            for part in self.calls[k].inputs:
                add(part, inward[at : at + part.size])
                at += part.size
        return by

    def gradient(self, part: Part) -> Any:
        """(n, 1) MX, the slope of a scalar by the variables."""
        pieces = self._backward([(part, ca.MX(1))])[0]
        return ca.densify(self.unit * sum(pieces, ca.MX(self.start.size, 1)))

    def hessian(self, weighed: Sequence[tuple[Part, Any]]) -> Any:
        """Second derivatives by the variables of a sum of parts, each with its weights (MX)."""
        by = self._backward(weighed)
        bends, inward = [], []
        for k, (function, inputs, numbers) in enumerate(self.calls):
            if by[k + 1] and function.bend_pattern.nnz():
                at = _gathered(self._slopes[0], inputs)
                nonzeros = function.bend(at, numbers, by[k + 1][0])
                bends.append((function.bend_pattern, nonzeros))
                inward.append(self._by_variables[1][k])
        # One product of all functions: a sum of many would be put together again and again.
        pattern = ca.diagcat(*(pattern for pattern, _ in bends))
        middle = ca.MX(pattern, ca.vertcat(*(nonzeros for _, nonzeros in bends)))
        D = ca.vertcat(*inward)
        return ca.mtimes(D.T, ca.mtimes(middle, D))


@dataclass(frozen=True, eq=False)
class Composed:
    """A stage, by its calls; as `llsrbm.ocp.horizon.StageExpressions`, without shared parameters.

    Attributes:
        states: how many of the variables are; equality: of each row, whether it is one.
        cost, rows, next_state: what calls gave; the last stage has no next state.
    """

    calls: Composition
    states: int
    cost: Part
    rows: Part
    next_state: Part | None
    equality: tuple[bool, ...]

    def constraints(self) -> Any:
        """MX, the negative next state over the rows."""
        gap = [] if self.next_state is None else [-self.calls.of(self.next_state)]
        return ca.vertcat(*gap, self.calls.of(self.rows))

    def as_text(self) -> str:
        """Every operation and number in it, as text that equal stages share."""
        arguments = [self.calls.variables, self.calls.numbers]
        values = [self.calls.of(self.cost), self.constraints()]
        text = ca.Function("stage", arguments, values).serialize()
        return f"{self.states} {self.equality} {text}"


def _gathered(sources: Sequence[Any], parts: Sequence[Part]) -> Any:
    pieces = []
    for part in parts:
        values = sources[part.source]
        whole = part.size == values.shape[0]
        pieces.append(values if whole else values[part.start : part.stop, :])
    return pieces[0] if len(pieces) == 1 else ca.vertcat(*pieces)
