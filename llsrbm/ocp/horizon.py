"""An optimal control problem as it is stated: stages in a row, each with its expressions."""

import hashlib
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import NamedTuple

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.ocp.composition import Composed
from llsrbm.ocp.lifting import Lifting


class Row(NamedTuple):
    """Path constraints of a stage that belong together."""

    expression: ca.SX  # SX, any shape
    equality: bool = False  # whether their lower bounds equal their upper ones


@dataclass(frozen=True, eq=False)
class StageExpressions:
    """One stage: symbols at an instant, and all that follows over the interval after it.

    Expressions may hold what `lift` has marked.
    """

    variables: ca.SX  # (n, 1) SX symbols, states first
    states: int  # how many of them are states
    shared: ca.SX  # (p, 1) SX symbols, the parameters of the whole problem, the same in every stage
    # (s, 1) SX symbols, parameters whose values are part of the shared ones, another part in
    # another run of stages.
    local: ca.SX
    cost: ca.SX  # SX scalar
    rows: tuple[Row, ...]  # path constraints
    next_state: ca.SX | None  # (m, 1) SX, the m states of the next stage; None at the end
    lift: Lifting  # collects the intermediates that derivatives run through

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
    """Consecutive stages with the same expressions and the same values of local parameters."""

    family: Hashable  # equal for runs with the same expressions
    count: int  # number of stages
    build: Callable[
        [], StageExpressions | Composed
    ]  # their expressions; called once for all runs of a family
    # Places of the local parameters in the shared ones, in their order.
    local: tuple[slice, ...] = ()
    # Of each stage, the place of the last of its local parameters, which it has for itself; ()
    # where stages have none.
    own: tuple[slice, ...] = ()


@dataclass(frozen=True, eq=False)
class Horizon:
    """All stages, in order; the last one has no next state."""

    runs: tuple[Run, ...]  # of stages
    parameters: int  # number of shared parameters
    _built: dict[Hashable, StageExpressions | Composed] = field(default_factory=dict, init=False)

    def expressions(self, run: Run) -> StageExpressions | Composed:
        """Those of a run, built once a family."""
        if run.family not in self._built:
            self._built[run.family] = run.build()
        return self._built[run.family]

    def fingerprint(self) -> str:
        """A digest of every operation and number that makes the problem."""
        families: dict[Hashable, int] = {}
        digest = hashlib.sha256(str(self.parameters).encode())
        for run in self.runs:
            if run.family not in families:
                families[run.family] = len(families)
                digest.update(self.expressions(run).as_text().encode())
            digest.update(f"{families[run.family], run.count, run.local, run.own}".encode())
        return digest.hexdigest()


@dataclass(frozen=True, eq=False)
class Problem:
    """The numbers of one request; the expressions are those of a `Transcription`.

    Raises `ValueError` where a row has no bound at all: where the set of such rows changes, CasADi
    makes Fatrop anew without its options, and that solver keeps none from then on.
    """

    parameters: Array  # (n,), shared by all stages
    lower: Array  # (rows,) bounds of g: of each stage its gap to the next, zeros, and its rows
    upper: Array  # (rows,) bounds of g: of each stage its gap to the next, zeros, and its rows

    def __post_init__(self) -> None:
        free = np.flatnonzero(np.isneginf(self.lower) & np.isposinf(self.upper))
        if len(free):
            raise ValueError(f"rows need a bound, a far one if no other: {free.tolist()} have none")


@dataclass(frozen=True, eq=False)
class Iterate:
    """A point in a solver's own order and units: where a next solve may start."""

    variables: Array  # (n,), stage after stage, states before controls
    multipliers: Array  # (rows,) of g


@dataclass(frozen=True, eq=False)
class Solution(Iterate):
    """Where a solve ended, and how it got there."""

    converged: bool  # as the solver reports
    iterations: int  # of this solve
    cost: float  # of this solve
    solve_time_s: float  # of this solve
    violation: float  # the largest of a row, in their units of about 1
    message: str  # the solver's status
