"""One stage as functions of numbers: cost, constraints, exact derivatives; for many stages at once.

`batched` makes one operation on a vector, with an element a stage, of each instruction of CasADi's
virtual machine; `mapped` is the loop for a compiler. `llsrbm.ocp` says why.
"""

from dataclasses import dataclass
from typing import Any

import casadi as ca

from llsrbm.abandon import go_on
from llsrbm.ocp.composition import Composed
from llsrbm.ocp.derivatives import Derivatives
from llsrbm.ocp.horizon import StageExpressions

# Below this number of stages decoding scalar instructions costs less than calling vector ones.
WORTHWHILE = 6
_STEP = 10_000  # instructions, some 0.1 s


@dataclass(frozen=True)
class StageFunctions:
    """Functions of (z, p, s) of one stage: its variables, shared and local parameters.

    g stacks -F(z), the next state, over the path rows.
    """

    cost: ca.Function  # f
    constraints: ca.Function  # g
    gradient: ca.Function  # df/dz
    # g, and the non-zeros of dg/dz under the identity of the previous stage's gap.
    jacobian: ca.Function
    hessian: ca.Function  # of lam_f f + lam . g, arguments (z, p, s, lam_f, lam), non-zeros.
    jacobian_pattern: ca.Sparsity  # their sparsities
    hessian_pattern: ca.Sparsity  # their sparsities
    states: int  # number of states
    gap: int  # rows of g that are the next state's gap
    equality: tuple[bool, ...]  # of each row of g, whether it is an equality

    @property
    def width(self) -> int:
        """Variables of a stage."""
        return int(self.constraints.size1_in(0))

    @property
    def height(self) -> int:
        """Rows of g of a stage."""
        return int(self.constraints.size1_out(0))


def make_stage_functions(
    name: str, stage: StageExpressions | Composed, initial: bool
) -> StageFunctions:
    """Differentiate one stage; `name` begins its functions' names; `initial`: it is the first."""
    if isinstance(stage, Composed):
        return _of_composed(name, stage, initial)
    return _of_expressions(name, stage, initial)


def _of_expressions(name: str, stage: StageExpressions, initial: bool) -> StageFunctions:
    z, p, s = stage.variables, stage.shared, stage.local
    rows = [(row, ca.vec(ca.SX(row.expression))) for row in stage.rows]
    gap = ca.SX(0, 1) if stage.next_state is None else -stage.next_state
    g = ca.densify(ca.vertcat(gap, *(expression for _, expression in rows)))

    inner = Derivatives(name, stage.lift, [p, s], ca.vertcat(stage.cost, g))
    values = stage.lift.resolve(ca.vertcat(stage.cost, g))
    cost, constraints = ca.vertsplit(values, [0, 1, values.shape[0]])
    inputs = [z, p, s]
    in_numbers = [ca.MX.sym(each, x.numel()) for each, x in zip("zps", inputs, strict=True)]
    lam_f, lam = ca.MX.sym("lam_f"), ca.MX.sym("lam", g.shape[0])
    outputs, J = inner.jacobian(*in_numbers)
    J = ca.vertcat(_gap_before(stage.states, z.numel(), initial), J[1:, :])
    H = inner.hessian(*in_numbers, ca.vertcat(lam_f, lam))

    def function(kind: str, arguments: list[Any], results: list[Any]) -> ca.Function:
        go_on()
        return ca.Function(f"{name}_{kind}", arguments, results)

    def of_scalars(kind: str, result: ca.SX) -> ca.Function:
        go_on()
        return ca.Function(f"{name}_{kind}", inputs, [result], {"cse": True})

    return StageFunctions(
        cost=of_scalars("f", cost),
        constraints=of_scalars("g", constraints),
        gradient=of_scalars("df", ca.densify(ca.gradient(cost, z))),
        jacobian=function("dg", in_numbers, [outputs[1:], ca.vec(J.nz[:])]),
        hessian=function("h", [*in_numbers, lam_f, lam], [ca.vec(H.nz[:])]),
        jacobian_pattern=J.sparsity(),
        hessian_pattern=H.sparsity(),
        states=stage.states,
        gap=gap.shape[0],
        equality=(True,) * gap.shape[0]
        + tuple(row.equality for row, values in rows for _ in range(values.shape[0])),
    )


def _gap_before(states: int, width: int, initial: bool) -> Any:
    """The identity of the gap that ends in a stage; none in the first."""
    return ca.MX(0, width) if initial else ca.MX.eye(width)[:states, :]


def _of_composed(name: str, stage: Composed, initial: bool) -> StageFunctions:
    calls, gap = stage.calls, 0 if stage.next_state is None else stage.states
    z, width = calls.variables, calls.start.size
    parts = [stage.rows] if stage.next_state is None else [stage.next_state, stage.rows]
    lam_f, lam = ca.MX.sym("lam_f"), ca.MX.sym("lam", gap + stage.rows.size)
    sign = ca.vertcat(-ca.DM.ones(gap), ca.DM.ones(stage.rows.size))
    g, J = calls.jacobian(parts)
    J = ca.vertcat(_gap_before(stage.states, width, initial), ca.mtimes(ca.diag(sign), J))
    weights = ca.vertsplit(sign * lam, [0, gap, gap + stage.rows.size])[-len(parts) :]
    H = calls.hessian([(stage.cost, lam_f), *zip(parts, weights, strict=True)])

    def function(kind: str, results: list[Any], *more: Any) -> ca.Function:
        go_on()
        arguments = [z, ca.MX.sym("p", 0), calls.numbers, *more]
        return ca.Function(f"{name}_{kind}", arguments, results)

    return StageFunctions(
        cost=function("f", [calls.of(stage.cost)]),
        constraints=function("g", [stage.constraints()]),
        gradient=function("df", [calls.gradient(stage.cost)]),
        jacobian=function("dg", [sign * g, ca.vec(J.nz[:])]),
        hessian=function("h", [ca.vec(H.nz[:])], lam_f, lam),
        jacobian_pattern=J.sparsity(),
        hessian_pattern=H.sparsity(),
        states=stage.states,
        gap=gap,
        equality=(True,) * gap + stage.equality,
    )


def mapped(function: ca.Function, count: int, *arguments: Any) -> list[Any]:
    """Evaluate a function of dense inputs for `count` stages, one after the other.

    `arguments`: MX, (size, count) with a column a stage, or (size, 1) where all share it. Returns
    MX (size, count) for each output.
    """
    repeated = [ca.repmat(a, 1, count) if a.shape[1] != count else a for a in arguments]
    return list(function.map(count).call(repeated))


def batched(function: ca.Function, count: int, *arguments: Any) -> list[Any]:
    """Evaluate a function as `mapped` does; one of scalars, of an expression, instruction by
    instruction for all stages.
    """
    go_on()
    if count < WORTHWHILE or not function.is_a("SXFunction"):
        return mapped(function, count, *arguments)
    inputs = []
    for argument in arguments:
        shared = argument.shape[1] != count
        inputs.append(ca.vertsplit(argument) if shared else ca.horzsplit(argument.T))
    outputs: list[list[Any]] = [[None] * function.numel_out(j) for j in range(function.n_out())]
    work: dict[int, Any] = {}
    for k in range(function.n_instructions()):
        if k % _STEP == 0:
            go_on()
        operation = function.instruction_id(k)
        take, give = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_INPUT:
            work[give[0]] = inputs[take[0]][take[1]]
        elif operation == ca.OP_OUTPUT:
            outputs[give[0]][give[1]] = work[take[0]]
        elif operation == ca.OP_CONST:
            work[give[0]] = ca.MX(function.instruction_constant(k))
        elif len(take) == 1:
            work[give[0]] = ca.MX.unary(operation, work[take[0]])
        else:
            work[give[0]] = ca.MX.binary(operation, work[take[0]], work[take[1]])

    def column(value: Any) -> Any:
        value = ca.MX(0) if value is None else value
        return value if value.numel() == count else ca.repmat(value, count, 1)

    return [ca.horzcat(*map(column, rows)).T if rows else ca.MX(0, count) for rows in outputs]
