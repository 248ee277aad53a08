"""Multiple shooting: stages into one sparse problem, with its derivatives, for any solver.

Each role becomes small functions of one stage, evaluated for all stages that share them at once;
the problem's functions assemble their non-zeros. This evaluates several times faster than one flat
expression of the whole horizon, needs no compiler, and is small enough to be kept on disk.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from llsrbm.models.base import CentroidalModel
from llsrbm.ocp.batch import over_stages
from llsrbm.ocp.stage_functions import StageFunctions, constraints_of, make_stage_functions
from llsrbm.planning.layout import Layout, Role
from llsrbm.planning.stage import Stage
from llsrbm.planning.task import Task, parameter_sizes

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Block:
    """A run of stages of one role, and where its part of the problem begins.

    Attributes:
        count: number of stages; width, height: variables and rows of g of one stage.
        gap: rows of g that are the next state's gap.
        first_variable, first_row: places in x and g.
    """

    role: Role
    functions: StageFunctions
    count: int
    width: int
    height: int
    gap: int
    first_variable: int
    first_row: int

    def columns(self, vector: Any, first: int, size: int) -> Any:
        """(size, count): the block's part of x or of the multipliers, a column a stage."""
        return ca.reshape(vector[first : first + self.count * size], size, self.count)


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
        sizes = parameter_sizes(layout)
        parameters = {name: ca.SX.sym(name, size) for name, size in sizes.items()}
        families: dict[tuple[Any, ...], StageFunctions] = {}
        blocks: list[Block] = []
        variable = row = 0
        for role, knots in layout.blocks():
            following = () if role.terminal else layout.states(layout.roles[knots[-1] + 1])
            family = _family(role, following, layout)
            if family not in families:
                stage = Stage(role, layout, model, parameters)
                families[family] = make_stage_functions(stage, following, knots[0] == 0)
            functions = families[family]
            width, height = functions.constraints.size1_in(0), functions.constraints.size1_out(0)
            gap = sum(map(layout.size, following))
            blocks.append(Block(role, functions, len(knots), width, height, gap, variable, row))
            variable, row = variable + len(knots) * width, row + len(knots) * height
            for _ in knots:
                self.row_counts.append(height - gap)
                equality += [True] * gap
                for constraint, count in functions.row_counts:
                    equality += [constraint.equality] * count
        self.equality = np.array(equality)
        self.functions = _assemble(blocks, sizes)


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


def _family(role: Role, following: tuple[str, ...], layout: Layout) -> tuple[Any, ...]:
    """Equal for stages with the same expressions: inner ones of take-off and landing are."""
    inner = role.in_contact and not role.first and not role.last
    name = "stance" if inner else role.describe()
    return name, layout.intervals_of(role.phase), following, constraints_of(role)


def _assemble(blocks: list[Block], sizes: dict[str, int]) -> dict[str, ca.Function]:
    variables = sum(block.count * block.width for block in blocks)
    rows = sum(block.count * block.height for block in blocks)
    parameters = sum(sizes.values())
    x, p = ca.MX.sym("x", variables), ca.MX.sym("p", parameters)
    lam_f, lam = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", rows)

    def every(kind: str) -> list[list[Any]]:
        return _evaluate(blocks, kind, x, _named(p, sizes), p, lam_f, lam)

    def with_gaps(block: Block, g: Any) -> Any:
        # The gap reads x_next - F, the sign that Fatrop expects.
        if not block.gap:
            return ca.vec(g)
        starts = [block.first_variable + (i + 1) * block.width for i in range(block.count)]
        following = ca.horzcat(*(x[at : at + block.gap] for at in starts))
        rest = ca.MX(block.height - block.gap, block.count)
        return ca.vec(g + ca.densify(ca.vertcat(following, rest)))

    def stack(parts: list[Any]) -> Any:
        return ca.vertcat(*map(ca.vec, parts))

    cost = sum(ca.sum2(f) for (f,) in every("cost"))
    df = stack([gradient for (gradient,) in every("gradient")])
    g = stack([with_gaps(b, part) for b, (part,) in zip(blocks, every("constraints"), strict=True)])
    both = every("jacobian")
    g_J = stack([with_gaps(b, part) for b, (part, _) in zip(blocks, both, strict=True)])
    J = ca.MX(_stacked(blocks, rows, variables), stack([nonzeros for _, nonzeros in both]))
    H_pattern = ca.diagcat(*(b.functions.hessian_pattern for b in blocks for _ in range(b.count)))
    H = ca.MX(H_pattern, stack([nonzeros for (nonzeros,) in every("hessian")]))
    slope = lam_f * df + ca.mtimes(J.T, lam)
    xp, all_in = [x, p], [x, p, lam_f, lam]
    names = ["x", "p", "lam_f", "lam_g"]
    definitions: dict[str, tuple[list[Any], list[Any], list[str]]] = {
        "nlp": (xp, [cost, g], ["f", "g"]),
        "nlp_f": (xp, [cost], ["f"]),
        "nlp_g": (xp, [g], ["g"]),
        "nlp_grad_f": (xp, [df], ["grad_f_x"]),
        "nlp_jac_g": (xp, [g_J, J], ["g", "jac_g_x"]),
        # Neither solver reads the gradient here; it would cost as much as the Jacobian.
        "nlp_hess_l": (all_in, [ca.MX(variables, 1), H], ["grad_gamma_x", "hess_gamma_x_x"]),
        "nlp_grad": (
            all_in,
            [cost, g, slope, ca.MX(parameters, 1)],
            ["f", "g", "grad_gamma_x", "grad_gamma_p"],
        ),
    }
    return {
        name: ca.Function(name, arguments, results, names[: len(arguments)], names_out)
        for name, (arguments, results, names_out) in definitions.items()
    }


def _named(p: Any, sizes: dict[str, int]) -> dict[str, Any]:
    places = np.cumsum([0, *sizes.values()]).tolist()
    return dict(zip(sizes, ca.vertsplit(p, places), strict=True))


def _evaluate(
    blocks: list[Block], kind: str, x: Any, named: dict[str, Any], p: Any, lam_f: Any, lam: Any
) -> list[list[Any]]:
    """Outputs of one of `StageFunctions`, (size, count) each, for each block."""
    sharing: dict[int, list[int]] = defaultdict(list)
    for index, block in enumerate(blocks):
        sharing[id(block.functions)].append(index)
    results: list[list[Any]] = [[] for _ in blocks]
    for indices in sharing.values():
        members = [blocks[i] for i in indices]
        count = sum(block.count for block in members)
        Z = ca.horzcat(*(b.columns(x, b.first_variable, b.width) for b in members))
        feet = ca.horzcat(
            *(
                ca.repmat(
                    ca.vertcat(*(named[name] for name in Stage.standing_parameters(b.role))),
                    1,
                    b.count,
                )
                for b in members
            )
        )
        arguments = [Z, p, feet]
        if kind == "hessian":
            arguments += [
                lam_f,
                ca.horzcat(*(b.columns(lam, b.first_row, b.height) for b in members)),
            ]
        outputs = over_stages(getattr(members[0].functions, kind), count, *arguments)
        split = np.cumsum([0, *(block.count for block in members)]).tolist()
        for output in outputs:
            for index, part in zip(indices, ca.horzsplit(output, split), strict=True):
                results[index].append(part)
    return results


def _stacked(blocks: list[Block], rows: int, variables: int) -> ca.Sparsity:
    """Stage Jacobians below each other; each one's identity rows belong to the gap before it."""
    found: list[NDArray[np.int64]] = []
    colind = [0]
    start = previous = 0
    for block in (b for b in blocks for _ in range(b.count)):
        pattern = block.functions.jacobian_pattern
        row = np.array(pattern.row())
        identity = pattern.size1() - block.height
        found.append(np.where(row < identity, row + previous, row - identity + start))
        colind += (colind[-1] + np.array(pattern.colind()[1:])).tolist()
        previous, start = start, start + block.height
    return ca.Sparsity(rows, variables, colind, np.concatenate(found).tolist())
