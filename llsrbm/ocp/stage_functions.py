"""One stage as functions of numbers: cost, constraints and their exact derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from llsrbm.planning.constraints import CONSTRAINTS, Constraint
from llsrbm.planning.costs import COSTS, weight_parameter
from llsrbm.planning.layout import Role
from llsrbm.planning.stage import Stage


@dataclass(frozen=True)
class StageFunctions:
    """Functions of (z, p, s) of one stage: its variables, the parameters, where its feet stand.

    g stacks -F(z), the next state, over the path rows.

    Attributes:
        cost: f; constraints: g; gradient: df/dz.
        jacobian: g, and the non-zeros of dg/dz under the identity of the previous stage's gap.
        hessian: of lam_f f + lam . g, arguments (z, p, s, lam_f, lam), non-zeros.
        jacobian_pattern, hessian_pattern: their sparsities.
        row_counts: path rows of each constraint, in their order.
    """

    cost: ca.Function
    constraints: ca.Function
    gradient: ca.Function
    jacobian: ca.Function
    hessian: ca.Function
    jacobian_pattern: ca.Sparsity
    hessian_pattern: ca.Sparsity
    row_counts: tuple[tuple[Constraint, int], ...]


def constraints_of(role: Role) -> tuple[Constraint, ...]:
    """The constraints that apply to a role, in the order of their rows."""
    return tuple(c for c in CONSTRAINTS if c.applies(role))


def make_stage_functions(stage: Stage, following: tuple[str, ...], initial: bool) -> StageFunctions:
    """Differentiate one stage.

    Args:
        stage: its expressions.
        following: names of the states at the next knot; none at the end.
        initial: whether no stage comes before.
    """
    z, p = stage.variables, ca.vertcat(*stage.parameters.values())
    s = stage.standing
    cost = ca.SX(0)
    for term in COSTS:
        if term.applies(stage.role):
            cost += stage.parameters[weight_parameter(term)] * term.term(stage)
    rows = [(c, ca.vec(ca.SX(c.rows(stage)))) for c in constraints_of(stage.role)]
    gap = -stage.next_state(following) if following else ca.SX(0, 1)
    g = ca.densify(ca.vertcat(gap, *(expression for _, expression in rows)))

    lam_f, lam = ca.SX.sym("lam_f"), ca.SX.sym("lam", g.shape[0])
    J = stage.lift.jacobian(g)
    gradient = ca.densify(stage.lift.jacobian(cost).T)
    H = ca.triu2symm(ca.triu(stage.lift.hessian(lam_f * cost + ca.dot(lam, g))))
    states = stage.layout.state_size(stage.role)
    gap_before = ca.SX(0, z.numel())
    if not initial:
        gap_before = ca.horzcat(ca.SX.eye(states), ca.SX(states, z.numel() - states))
    J = ca.vertcat(gap_before, J)

    def function(kind: str, arguments: list[Any], results: list[ca.SX]) -> ca.Function:
        # One substitution for all results of a function keeps what they share shared.
        joined = stage.lift.resolve(ca.vertcat(*results))
        split = np.cumsum([0, *(r.shape[0] for r in results)]).tolist()
        outputs = ca.vertsplit(joined, split)
        return ca.Function(f"{stage.role.describe()}_{kind}", arguments, outputs, {"cse": True})

    return StageFunctions(
        cost=function("f", [z, p, s], [cost]),
        constraints=function("g", [z, p, s], [g]),
        gradient=function("df", [z, p, s], [gradient]),
        jacobian=function("dg", [z, p, s], [g, _nonzeros(J)]),
        hessian=function("h", [z, p, s, lam_f, lam], [_nonzeros(H)]),
        jacobian_pattern=J.sparsity(),
        hessian_pattern=H.sparsity(),
        row_counts=tuple((c, expression.shape[0]) for c, expression in rows),
    )


def _nonzeros(matrix: ca.SX) -> ca.SX:
    return ca.vertcat(*matrix.nonzeros()) if matrix.nnz() else ca.SX(0, 1)
