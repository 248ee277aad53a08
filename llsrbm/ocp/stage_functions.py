"""One stage as functions of numbers: cost, constraints and their exact derivatives."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from llsrbm.ocp.horizon import StageExpressions


@dataclass(frozen=True)
class StageFunctions:
    """Functions of (z, p, s) of one stage: its variables, shared and local parameters.

    g stacks -F(z), the next state, over the path rows.

    Attributes:
        cost: f; constraints: g; gradient: df/dz.
        jacobian: g, and the non-zeros of dg/dz under the identity of the previous stage's gap.
        hessian: of lam_f f + lam . g, arguments (z, p, s, lam_f, lam), non-zeros.
        jacobian_pattern, hessian_pattern: their sparsities.
        states: number of states; gap: rows of g that are the next state's gap.
        rows: key, number and equality flag of the path rows, in their order.
    """

    cost: ca.Function
    constraints: ca.Function
    gradient: ca.Function
    jacobian: ca.Function
    hessian: ca.Function
    jacobian_pattern: ca.Sparsity
    hessian_pattern: ca.Sparsity
    states: int
    gap: int
    rows: tuple[tuple[Hashable, int, bool], ...]

    @property
    def width(self) -> int:
        """Variables of a stage."""
        return int(self.constraints.size1_in(0))

    @property
    def height(self) -> int:
        """Rows of g of a stage."""
        return int(self.constraints.size1_out(0))


def make_stage_functions(stage: StageExpressions, initial: bool) -> StageFunctions:
    """Differentiate one stage.

    Args:
        stage: its expressions.
        initial: whether no stage comes before.
    """
    z, p, s = stage.variables, stage.shared, stage.local
    rows = [(row, ca.vec(ca.SX(row.expression))) for row in stage.rows]
    gap = ca.SX(0, 1) if stage.next_state is None else -stage.next_state
    g = ca.densify(ca.vertcat(gap, *(expression for _, expression in rows)))

    lam_f, lam = ca.SX.sym("lam_f"), ca.SX.sym("lam", g.shape[0])
    J = stage.lift.jacobian(g)
    gradient = ca.densify(stage.lift.jacobian(stage.cost).T)
    H = ca.triu2symm(ca.triu(stage.lift.hessian(lam_f * stage.cost + ca.dot(lam, g))))
    gap_before = ca.SX(0, z.numel())
    if not initial:
        gap_before = ca.horzcat(
            ca.SX.eye(stage.states), ca.SX(stage.states, z.numel() - stage.states)
        )
    J = ca.vertcat(gap_before, J)

    def function(kind: str, arguments: list[Any], results: list[ca.SX]) -> ca.Function:
        # One substitution for all results of a function keeps what they share shared.
        joined = stage.lift.resolve(ca.vertcat(*results))
        split = np.cumsum([0, *(r.shape[0] for r in results)]).tolist()
        outputs = ca.vertsplit(joined, split)
        return ca.Function(f"{stage.name}_{kind}", arguments, outputs, {"cse": True})

    return StageFunctions(
        cost=function("f", [z, p, s], [stage.cost]),
        constraints=function("g", [z, p, s], [g]),
        gradient=function("df", [z, p, s], [gradient]),
        jacobian=function("dg", [z, p, s], [g, _nonzeros(J)]),
        hessian=function("h", [z, p, s, lam_f, lam], [_nonzeros(H)]),
        jacobian_pattern=J.sparsity(),
        hessian_pattern=H.sparsity(),
        states=stage.states,
        gap=gap.shape[0],
        rows=tuple((row.key, expression.shape[0], row.equality) for row, expression in rows),
    )


def _nonzeros(matrix: ca.SX) -> ca.SX:
    return ca.vertcat(*matrix.nonzeros()) if matrix.nnz() else ca.SX(0, 1)
