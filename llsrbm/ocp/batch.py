"""One scalar function evaluated for many stages at once, instruction by instruction.

Each instruction of CasADi's virtual machine becomes one operation on a vector with an element a
stage, without a compiler; `llsrbm.ocp` says why.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

# Below this number of stages decoding scalar instructions costs less than calling vector ones.
WORTHWHILE = 6


def over_stages(function: ca.Function, count: int, *arguments: Any) -> list[Any]:
    """Evaluate an SX function for `count` stages.

    Args:
        function: scalar expressions (SX), dense inputs and outputs.
        count: number of stages.
        arguments: MX, (size, count) with a column a stage, or (size, 1) where all share it.

    Returns:
        MX (size, count) for each output.
    """
    if count < WORTHWHILE:
        repeated = [ca.repmat(a, 1, count) if a.shape[1] != count else a for a in arguments]
        return list(function.map(count).call(repeated) if count > 1 else function.call(repeated))
    inputs = []
    for argument in arguments:
        shared = argument.shape[1] != count
        inputs.append(ca.vertsplit(argument) if shared else ca.horzsplit(argument.T))
    outputs: list[list[Any]] = [[None] * function.numel_out(j) for j in range(function.n_out())]
    work: dict[int, Any] = {}
    for k in range(function.n_instructions()):
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
