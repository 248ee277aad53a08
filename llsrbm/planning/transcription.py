"""Multiple shooting: stages into one sparse problem, with its derivatives, for any solver.

Each role becomes small functions of one stage, mapped over the stages that share it; the problem's
functions assemble their non-zeros. This evaluates several times faster than one flat expression of
the whole horizon, needs no compiler, and is small enough to be kept on disk.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from llsrbm.models.base import CentroidalModel
from llsrbm.planning.constraints import CONSTRAINTS, Constraint
from llsrbm.planning.costs import COSTS, weight_parameter
from llsrbm.planning.layout import Layout, Role
from llsrbm.planning.stage import Stage
from llsrbm.planning.task import Task, parameter_sizes

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StageFunctions:
    """Functions of (z, p) of one stage; g stacks -F(z), the next state, over the path rows.

    Attributes:
        cost: f; constraints: g; gradient: df/dz.
        jacobian: (g, non-zeros of dg/dz under the identity of the previous stage's gap).
        hessian: of lam_f f + lam . g, arguments (z, p, lam_f, lam), non-zeros.
        jacobian_pattern, hessian_pattern: their sparsities.
    """

    cost: ca.Function
    constraints: ca.Function
    gradient: ca.Function
    jacobian: ca.Function
    hessian: ca.Function
    jacobian_pattern: ca.Sparsity
    hessian_pattern: ca.Sparsity


def constraints_of(role: Role) -> tuple[Constraint, ...]:
    """The constraints that apply to a role, in the order of their rows."""
    return tuple(c for c in CONSTRAINTS if c.applies(role))


class Problem:
    """The parametric problem of one model and layout.

    Attributes:
        functions: name -> CasADi function, in the signatures that nlpsol expects of its oracle:
            nlp, nlp_f, nlp_g, nlp_grad_f, nlp_jac_g, nlp_hess_l, nlp_grad.
        state_sizes, control_sizes, row_counts: (N+1,) nx, nu and path rows a stage.
        equality: (rows,) whether a row of g is an equality.
    """

    def __init__(self, model: CentroidalModel, layout: Layout) -> None:
        self.model, self.layout = model, layout
        self.state_sizes = [layout.state_size(role) for role in layout.roles]
        self.control_sizes = [layout.control_size(role) for role in layout.roles]
        self.row_counts: list[int] = []
        equality: list[bool] = []
        parameters = {
            name: ca.SX.sym(name, size) for name, size in parameter_sizes(layout.legs).items()
        }
        blocks = []
        for role, knots in layout.blocks():
            stage = Stage(role, layout, model, parameters)
            following = () if role.terminal else layout.states(layout.roles[knots[-1] + 1])
            functions, rows = _stage_functions(stage, following, knots[0] == 0)
            blocks.append((functions, len(knots), stage, sum(map(layout.size, following))))
            for _ in knots:
                self.row_counts.append(sum(count for _, count in rows))
                equality += [True] * blocks[-1][3]
                for constraint, count in rows:
                    equality += [constraint.equality] * count
        self.equality = np.array(equality)
        self.functions = _assemble(blocks, layout, sum(s.numel() for s in parameters.values()))


def row_bounds(layout: Layout, task: Task) -> tuple[Array, Array]:
    """Lower and upper bounds of g for a task, (rows,): gaps, then each stage's constraints."""
    lower, upper = [], []
    for knot, role in enumerate(layout.roles):
        if not role.terminal:
            gap = np.zeros(layout.state_size(layout.roles[knot + 1]))
            lower.append(gap)
            upper.append(gap)
        for constraint in constraints_of(role):
            low, high = constraint.bounds(task, layout, knot)
            lower.append(low)
            upper.append(high)
    return np.concatenate(lower), np.concatenate(upper)


def _nonzeros(matrix: ca.SX) -> ca.SX:
    return ca.vertcat(*matrix.nonzeros()) if matrix.nnz() else ca.SX(0, 1)


def _stage_functions(
    stage: Stage, following: tuple[str, ...], initial: bool
) -> tuple[StageFunctions, list[tuple[Constraint, int]]]:
    z, p = stage.variables, ca.vertcat(*stage.parameters.values())
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

    name = stage.role.describe()
    resolve = stage.lift.resolve

    def function(kind: str, arguments: list[Any], results: list[ca.SX]) -> ca.Function:
        # One substitution for all results of a function keeps what they share shared.
        joined = resolve(ca.vertcat(*results))
        split = np.cumsum([0, *(r.shape[0] for r in results)]).tolist()
        outputs = ca.vertsplit(joined, split)
        return ca.Function(f"{name}_{kind}", arguments, outputs, {"cse": True})

    functions = StageFunctions(
        cost=function("f", [z, p], [cost]),
        constraints=function("g", [z, p], [g]),
        gradient=function("df", [z, p], [gradient]),
        jacobian=function("dg", [z, p], [g, _nonzeros(J)]),
        hessian=function("h", [z, p, lam_f, lam], [_nonzeros(H)]),
        jacobian_pattern=J.sparsity(),
        hessian_pattern=H.sparsity(),
    )
    return functions, [(c, expression.shape[0]) for c, expression in rows]


def _assemble(
    blocks: list[tuple[StageFunctions, int, Stage, int]], layout: Layout, parameters: int
) -> dict[str, ca.Function]:
    x, p = ca.MX.sym("x", layout.size_total), ca.MX.sym("p", parameters)
    rows_total = sum(n * f.constraints.size1_out(0) for f, n, _, _ in blocks)
    lam_f, lam = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", rows_total)

    def over_stages(function: ca.Function, count: int, *arguments: Any) -> Any:
        repeated = [ca.repmat(a, 1, count) if a.shape[1] != count else a for a in arguments]
        return function.map(count)(*repeated) if count > 1 else function(*repeated)

    cost: Any = 0
    g, gradient, g_with_jacobian, jacobian, hessian = [], [], [], [], []
    jacobian_patterns: list[tuple[ca.Sparsity, int]] = []
    hessian_patterns: list[ca.Sparsity] = []
    at, row = 0, 0
    for functions, count, stage, gap in blocks:
        width = stage.variables.numel()
        height = functions.constraints.size1_out(0)
        Z = ca.reshape(x[at : at + count * width], width, count)
        lams = ca.reshape(lam[row : row + count * height], height, count)
        following = [x[at + (i + 1) * width : at + (i + 1) * width + gap] for i in range(count)]
        next_states = ca.horzcat(*following) if gap else ca.MX(0, count)
        # The gap reads x_next - F, the sign that Fatrop expects.
        added = ca.densify(ca.vertcat(next_states, ca.MX(height - gap, count)))
        cost = cost + ca.sum2(over_stages(functions.cost, count, Z, p))
        gradient.append(ca.vec(over_stages(functions.gradient, count, Z, p)))
        g.append(ca.vec(over_stages(functions.constraints, count, Z, p) + added))
        stage_g, nonzeros = over_stages(functions.jacobian, count, Z, p)
        g_with_jacobian.append(ca.vec(stage_g + added))
        jacobian.append(ca.vec(nonzeros))
        hessian.append(ca.vec(over_stages(functions.hessian, count, Z, p, lam_f, lams)))
        jacobian_patterns += [(functions.jacobian_pattern, height)] * count
        hessian_patterns += [functions.hessian_pattern] * count
        at, row = at + count * width, row + count * height

    J = ca.MX(_stacked(jacobian_patterns, rows_total, layout.size_total), ca.vertcat(*jacobian))
    H = ca.MX(ca.diagcat(*hessian_patterns), ca.vertcat(*hessian))
    df, all_g = ca.vertcat(*gradient), ca.vertcat(*g)
    g_J = ca.vertcat(*g_with_jacobian)
    slope = lam_f * df + ca.mtimes(J.T, lam)
    xp, lams_in = [x, p], ["lam_f", "lam_g"]
    definitions: dict[str, tuple[list[Any], list[Any], list[str], list[str]]] = {
        "nlp": (xp, [cost, all_g], ["x", "p"], ["f", "g"]),
        "nlp_f": (xp, [cost], ["x", "p"], ["f"]),
        "nlp_g": (xp, [all_g], ["x", "p"], ["g"]),
        "nlp_grad_f": (xp, [df], ["x", "p"], ["grad_f_x"]),
        "nlp_jac_g": (xp, [g_J, J], ["x", "p"], ["g", "jac_g_x"]),
        "nlp_hess_l": (
            [x, p, lam_f, lam],
            [ca.MX(layout.size_total, 1), H],
            ["x", "p", *lams_in],
            ["grad_gamma_x", "hess_gamma_x_x"],
        ),
        "nlp_grad": (
            [x, p, lam_f, lam],
            [cost, all_g, slope, ca.MX(parameters, 1)],
            ["x", "p", *lams_in],
            ["f", "g", "grad_gamma_x", "grad_gamma_p"],
        ),
    }
    return {
        name: ca.Function(name, arguments, results, names_in, names_out)
        for name, (arguments, results, names_in, names_out) in definitions.items()
    }


def _stacked(
    patterns: list[tuple[ca.Sparsity, int]], rows_total: int, columns_total: int
) -> ca.Sparsity:
    """Stage Jacobians below each other; each one's identity rows belong to the gap before it."""
    rows: list[NDArray[np.int64]] = []
    colind = [0]
    start = previous = 0
    for pattern, height in patterns:
        row = np.array(pattern.row())
        identity = pattern.size1() - height
        rows.append(np.where(row < identity, row + previous, row - identity + start))
        colind += (colind[-1] + np.array(pattern.colind()[1:])).tolist()
        previous, start = start, start + height
    return ca.Sparsity(rows_total, columns_total, colind, np.concatenate(rows).tolist())
