"""Multiple shooting: stages into one sparse problem, with its derivatives, for any solver.

The non-zeros of the stage functions are put where they belong in the problem's own; `llsrbm.ocp`
says why.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from llsrbm.ocp.horizon import Horizon, Run, StageExpressions
from llsrbm.ocp.stage_functions import StageFunctions, batched, make_stage_functions


@dataclass(frozen=True)
class Block:
    """A run of stages, and where its part of the problem begins.

    Attributes:
        functions: of one stage.
        count: number of stages.
        local: places of their local parameters in the shared ones; own: of those that each stage
            has for itself.
        first_variable, first_row: places in x and g.
    """

    functions: StageFunctions
    count: int
    local: tuple[slice, ...]
    own: tuple[slice, ...]
    first_variable: int
    first_row: int

    @property
    def width(self) -> int:
        """Variables of one stage."""
        return self.functions.width

    @property
    def height(self) -> int:
        """Rows of g of one stage."""
        return self.functions.height

    @property
    def gap(self) -> int:
        """Rows of g of one stage that are the next state's gap."""
        return self.functions.gap

    def columns(self, vector: Any, first: int, size: int) -> Any:
        """(size, count): the block's part of x or of the multipliers, a column a stage."""
        return ca.reshape(vector[first : first + self.count * size], size, self.count)


@dataclass(frozen=True)
class Structure:
    """The sizes of an optimal control problem's stages, as Fatrop has to know them.

    Attributes:
        states, controls, rows: (N+1,) nx, nu and number of path rows of a stage.
        equality: (rows of g,) whether a row of g is an equality.
    """

    states: list[int]
    controls: list[int]
    rows: list[int]
    equality: list[bool]

    def as_lists(self) -> list[list[int]]:
        """All of it as whole numbers."""
        return [self.states, self.controls, self.rows, [int(equal) for equal in self.equality]]

    @classmethod
    def of_lists(cls, *lists: Sequence[float]) -> Structure:
        """The structure that `as_lists` gave, whole numbers as CasADi returns them."""
        states, controls, rows, equality = ([int(n) for n in numbers] for numbers in lists)
        return cls(states, controls, rows, [bool(equal) for equal in equality])


# CasADi functions in the signatures that nlpsol expects of its oracle.
FUNCTIONS = ("nlp", "nlp_f", "nlp_g", "nlp_grad_f", "nlp_jac_g", "nlp_hess_l", "nlp_grad")

# Evaluates a stage function for many stages, as `llsrbm.ocp.stage_functions.mapped` does.
Evaluate = Callable[..., list[Any]]


class Transcribed:
    """A parametric problem, as solvers take it.

    Attributes:
        functions: of each name in `FUNCTIONS`.
        structure: sizes of its stages.
    """

    def __init__(self, functions: dict[str, ca.Function], structure: Structure) -> None:
        self.functions, self.structure = functions, structure


class Transcription(Transcribed):
    """The parametric problem of a horizon.

    Attributes:
        blocks: its runs of stages, in order.
    """

    def __init__(self, horizon: Horizon) -> None:
        """Build each family's expressions once, differentiate and assemble them.

        Raises:
            ValueError: stages whose next state is not the state of the one that follows.
        """
        expressions: dict[Hashable, StageExpressions] = {}
        families: dict[tuple[Hashable, bool], StageFunctions] = {}
        blocks: list[Block] = []
        variable = row = 0
        for run, initial in _first_apart(horizon.runs):
            if run.family not in expressions:
                expressions[run.family] = run.build()
            family = run.family, initial
            if family not in families:
                families[family] = make_stage_functions(
                    f"stage{len(families)}", expressions[run.family], initial
                )
            block = Block(families[family], run.count, run.local, run.own, variable, row)
            blocks.append(block)
            variable += run.count * block.width
            row += run.count * block.height
        stages = [block.functions for block in blocks for _ in range(block.count)]
        for k, (stage, states) in enumerate(
            zip(stages, [*(after.states for after in stages[1:]), 0], strict=True)
        ):
            if stage.gap != states:
                raise ValueError(f"stage {k} leads to {stage.gap} states; the next has {states}")
        equality: list[bool] = []
        for stage in stages:
            equality += [True] * stage.gap
            for _, count, equal in stage.rows:
                equality += [equal] * count
        structure = Structure(
            states=[stage.states for stage in stages],
            controls=[stage.width - stage.states for stage in stages],
            rows=[stage.height - stage.gap for stage in stages],
            equality=equality,
        )
        self.blocks, self._parameters = tuple(blocks), horizon.parameters
        super().__init__(self.assembled(batched), structure)

    def assembled(self, evaluate: Evaluate) -> dict[str, ca.Function]:
        """`functions`, with another way to evaluate those of the stages."""
        return _assemble(self.blocks, self._parameters, evaluate)


def _first_apart(runs: tuple[Run, ...]) -> Iterator[tuple[Run, bool]]:
    """Runs, and whether they begin the horizon: no gap ends in the first stage."""
    first, *rest = runs
    yield replace(first, count=1, own=first.own[:1]), True
    if first.count > 1:
        yield replace(first, count=first.count - 1, own=first.own[1:]), False
    for run in rest:
        yield run, False


def _assemble(
    blocks: Sequence[Block], parameters: int, evaluate: Evaluate
) -> dict[str, ca.Function]:
    variables = sum(block.count * block.width for block in blocks)
    rows = sum(block.count * block.height for block in blocks)
    x, p = ca.MX.sym("x", variables), ca.MX.sym("p", parameters)
    lam_f, lam = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", rows)

    def every(kind: str) -> list[list[Any]]:
        return _evaluated(blocks, evaluate, kind, x, p, lam_f, lam)

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


def _evaluated(
    blocks: Sequence[Block], evaluate: Evaluate, kind: str, x: Any, p: Any, lam_f: Any, lam: Any
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
        local = ca.horzcat(*(_local(p, block) for block in members))
        arguments = [Z, p, local]
        if kind == "hessian":
            arguments += [
                lam_f,
                ca.horzcat(*(b.columns(lam, b.first_row, b.height) for b in members)),
            ]
        outputs = evaluate(getattr(members[0].functions, kind), count, *arguments)
        split = np.cumsum([0, *(block.count for block in members)]).tolist()
        for output in outputs:
            for index, part in zip(indices, ca.horzsplit(output, split), strict=True):
                results[index].append(part)
    return results


def _local(p: Any, block: Block) -> Any:
    """(size, count): local parameters, a column a stage."""
    shared = ca.vertcat(*(p[at] for at in block.local)) if block.local else ca.MX(0, 1)
    columns = ca.repmat(shared, 1, block.count)
    if not block.own:
        return columns
    return ca.vertcat(columns, ca.horzcat(*(p[at] for at in block.own)))


def _stacked(blocks: Sequence[Block], rows: int, variables: int) -> ca.Sparsity:
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
