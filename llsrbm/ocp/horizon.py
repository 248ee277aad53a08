"""An optimal control problem as it is stated: stages in a row, each with its expressions."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca

from llsrbm.ocp.lifting import Lifting


class Row(NamedTuple):
    """Path constraints of a stage that belong together.

    Attributes:
        expression: SX, any shape.
        equality: whether their lower bounds equal their upper ones.
    """

    expression: ca.SX
    equality: bool = False


@dataclass(frozen=True, eq=False)
class StageExpressions:
    """One stage: symbols at an instant, and all that follows over the interval after it.

    Expressions may hold what `lift` has marked.

    Attributes:
        variables: (n, 1) SX symbols, states first.
        states: how many of them are states.
        shared: (p, 1) SX symbols, the parameters of the whole problem, the same in every stage.
        local: (s, 1) SX symbols, parameters whose values are part of the shared ones, another
            part in another run of stages.
        cost: SX scalar.
        rows: path constraints.
        next_state: (m, 1) SX, the m states of the next stage; None at the end.
        lift: collects the intermediates that derivatives run through.
    """

    variables: ca.SX
    states: int
    shared: ca.SX
    local: ca.SX
    cost: ca.SX
    rows: tuple[Row, ...]
    next_state: ca.SX | None
    lift: Lifting

    def as_text(self) -> str:
        """Every operation and number in it, as text that equal stages share."""
        symbols, definitions = self.lift.marked
        following = ca.SX(0, 1) if self.next_state is None else self.next_state
        values = [self.cost, following, *(row.expression for row in self.rows), *definitions]
        arguments = [self.variables, self.shared, self.local, *symbols]
        sizes = self.states, [row.equality for row in self.rows]
        return f"{sizes} {ca.Function('stage', arguments, values).serialize()}"


@dataclass(frozen=True, eq=False)
class Run:
    """Consecutive stages with the same expressions and the same values of local parameters.

    Attributes:
        family: equal for runs with the same expressions.
        count: number of stages.
        build: their expressions; called once for all runs of a family.
        local: places of the local parameters in the shared ones, in their order.
        own: of each stage, the place of the last of its local parameters, which it has for itself;
            () where stages have none.
    """

    family: Hashable
    count: int
    build: Callable[[], StageExpressions]
    local: tuple[slice, ...] = ()
    own: tuple[slice, ...] = ()


@dataclass(frozen=True, eq=False)
class Horizon:
    """All stages, in order; the last one has no next state.

    Attributes:
        runs: of stages.
        parameters: number of shared parameters.
    """

    runs: tuple[Run, ...]
    parameters: int

    def fingerprint(self) -> str:
        """A digest of every operation and number that makes the problem."""
        families: dict[Hashable, int] = {}
        digest = hashlib.sha256(str(self.parameters).encode())
        for run in self.runs:
            if run.family not in families:
                families[run.family] = len(families)
                digest.update(run.build().as_text().encode())
            digest.update(f"{families[run.family], run.count, run.local, run.own}".encode())
        return digest.hexdigest()
