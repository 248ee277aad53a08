"""Multiple shooting: stages into one sparse problem, with its derivatives, for any solver.

The non-zeros of the stage functions are put where they belong in the problem's own; `llsrbm.ocp`
says why.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from llsrbm.arrays import IntArray
from llsrbm.ocp.horizon import Horizon
from llsrbm.ocp.stage_functions import StageFunctions, batched, make_stage_functions


class _Stage(NamedTuple):
    """A stage's functions, and its places in x, g and (those of its local parameters) p."""

    functions: StageFunctions
    variables: slice
    rows: slice
    local: tuple[slice, ...]


@dataclass(frozen=True)
class Structure:
    """The sizes of an optimal control problem's stages, as Fatrop has to know them."""

    states: list[int]  # (N+1,) nx, nu and number of path rows of a stage
    controls: list[int]  # (N+1,) nx, nu and number of path rows of a stage
    rows: list[int]  # (N+1,) nx, nu and number of path rows of a stage
    equality: list[bool]  # (rows of g,) whether a row of g is an equality

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

MEMORY_OF_TEXT = 1.4e-6  # MB a letter of a problem as text: 1.0 to 1.5 of ten solvers

# Evaluates a stage function for many stages, as `llsrbm.ocp.stage_functions.mapped` does.
Evaluate = Callable[..., list[Any]]


class Transcribed:
    """A parametric problem, as solvers take it: its `FUNCTIONS`, and the sizes of its stages."""

    def __init__(
        self, functions: dict[str, ca.Function], structure: Structure, megabytes: float = 0.0
    ) -> None:
        """`megabytes`: of memory that a solver of them takes, where that is known."""
        self.functions, self.structure, self.megabytes = functions, structure, megabytes

    def serialize(self) -> str:
        """The problem as text, for a cache."""
        serializer = ca.StringSerializer()
        serializer.pack([self.functions[name] for name in FUNCTIONS])
        for numbers in self.structure.as_lists():
            serializer.pack(numbers)
        return str(serializer.encode())

    @classmethod
    def deserialize(cls, text: str) -> Transcribed:
        """The problem that `serialize` wrote."""
        serializer = ca.StringDeserializer(text)
        functions = dict(zip(FUNCTIONS, serializer.unpack(), strict=True))
        structure = Structure.of_lists(*(serializer.unpack() for _ in range(4)))
        return Transcribed(functions, structure, MEMORY_OF_TEXT * len(text))


class Transcription(Transcribed):
    """The parametric problem of a horizon."""

    def __init__(self, horizon: Horizon) -> None:
        """Build each family's expressions once, differentiate and assemble them. Raises
        `ValueError`: stages whose next state is not the state of the one that follows.
        """
        self._stages, self._parameters = _placed(horizon), horizon.parameters
        stages = [stage.functions for stage in self._stages]
        following = [*(after.states for after in stages[1:]), 0]
        for k, (stage, states) in enumerate(zip(stages, following, strict=True)):
            if stage.gap != states:
                raise ValueError(f"stage {k} leads to {stage.gap} states; the next has {states}")
        structure = Structure(
            states=[stage.states for stage in stages],
            controls=[stage.width - stage.states for stage in stages],
            rows=[stage.height - stage.gap for stage in stages],
            equality=[equal for stage in stages for equal in stage.equality],
        )
        super().__init__(self.assembled(batched), structure)

    def assembled(self, evaluate: Evaluate) -> dict[str, ca.Function]:
        """`functions`, with another way to evaluate those of the stages."""
        return _assemble(self._stages, self._parameters, evaluate)


def _placed(horizon: Horizon) -> list[_Stage]:
    families: dict[tuple[Hashable, bool], StageFunctions] = {}
    stages: list[_Stage] = []
    variable = row = 0
    for run in horizon.runs:
        for k in range(run.count):
            family = run.family, not stages  # no gap ends in the first stage
            if family not in families:
                name = f"stage{len(families)}"
                families[family] = make_stage_functions(name, horizon.expressions(run), not stages)
            f = families[family]
            variables, rows = slice(variable, variable + f.width), slice(row, row + f.height)
            stages.append(_Stage(f, variables, rows, (*run.local, *run.own[k : k + 1])))
            variable, row = variables.stop, rows.stop
    return stages


def _assemble(
    stages: Sequence[_Stage], parameters: int, evaluate: Evaluate
) -> dict[str, ca.Function]:
    variables, rows = stages[-1].variables.stop, stages[-1].rows.stop
    x, p = ca.MX.sym("x", variables), ca.MX.sym("p", parameters)
    lam_f, lam = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", rows)

    def every(kind: str) -> list[list[Any]]:
        """Outputs of one of `StageFunctions`, each one's of all stages."""
        return _evaluated(stages, evaluate, kind, x, p, lam_f, lam)

    def with_gaps(parts: list[Any]) -> Any:
        # The gap reads x_next - F, the sign that Fatrop expects.
        found = []
        for stage, g in zip(stages, parts, strict=True):
            gap, end = stage.functions.gap, stage.variables.stop
            found += [g[:gap] + x[end : end + gap], g[gap:]]
        return ca.vertcat(*found)

    (costs,), (gradients,), (constraints,) = map(every, ("cost", "gradient", "constraints"))
    (constraints_J, J_nonzeros), (H_nonzeros,) = every("jacobian"), every("hessian")
    cost, df, g = ca.sum1(ca.vertcat(*costs)), ca.vertcat(*gradients), with_gaps(constraints)
    J = ca.MX(_jacobian_pattern(stages), ca.vertcat(*J_nonzeros))
    H_pattern = ca.diagcat(*(stage.functions.hessian_pattern for stage in stages))
    H = ca.MX(H_pattern, ca.vertcat(*H_nonzeros))
    slope = lam_f * df + ca.mtimes(J.T, lam)
    xp, all_in = [x, p], [x, p, lam_f, lam]
    names = ["x", "p", "lam_f", "lam_g"]
    definitions: dict[str, tuple[list[Any], list[Any], list[str]]] = {
        "nlp": (xp, [cost, g], ["f", "g"]),
        "nlp_f": (xp, [cost], ["f"]),
        "nlp_g": (xp, [g], ["g"]),
        "nlp_grad_f": (xp, [df], ["grad_f_x"]),
        "nlp_jac_g": (xp, [with_gaps(constraints_J), J], ["g", "jac_g_x"]),
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
    stages: Sequence[_Stage], evaluate: Evaluate, kind: str, x: Any, p: Any, lam_f: Any, lam: Any
) -> list[list[Any]]:
    sharing: dict[int, list[int]] = defaultdict(list)
    for index, stage in enumerate(stages):
        sharing[id(stage.functions)].append(index)
    results: dict[int, list[Any]] = {}
    for indices in sharing.values():
        members = [stages[index] for index in indices]
        local = (ca.vertcat(ca.MX(0, 1), *(p[at] for at in stage.local)) for stage in members)
        # Of stages that share none, no copy of all parameters a stage.
        shared = p if members[0].functions.cost.size1_in(1) else ca.MX(0, 1)
        variables = ca.horzcat(*(x[stage.variables] for stage in members))
        arguments = [variables, shared, ca.horzcat(*local)]
        if kind == "hessian":
            arguments += [lam_f, ca.horzcat(*(lam[stage.rows] for stage in members))]
        outputs = evaluate(getattr(members[0].functions, kind), len(members), *arguments)
        columns = zip(*map(ca.horzsplit, outputs), strict=True)
        results |= {index: list(each) for index, each in zip(indices, columns, strict=True)}
    return [list(each) for each in zip(*(results[k] for k in range(len(stages))), strict=True)]


def _jacobian_pattern(stages: Sequence[_Stage]) -> ca.Sparsity:
    """Stage Jacobians below each other; each one's identity rows belong to the gap before it."""
    found: list[IntArray] = []
    colind = [0]
    before = 0
    for stage in stages:
        pattern = stage.functions.jacobian_pattern
        row = np.array(pattern.row())
        identity = pattern.size1() - stage.functions.height
        found.append(np.where(row < identity, row + before, row - identity + stage.rows.start))
        colind += (colind[-1] + np.array(pattern.colind()[1:])).tolist()
        before = stage.rows.start
    rows, variables = stages[-1].rows.stop, stages[-1].variables.stop
    return ca.Sparsity(rows, variables, colind, np.concatenate(found).tolist())
