"""Solvers of the controller's quadratic program, found by name; one file and one line here each."""

from __future__ import annotations

from llsrbm.control.solvers.base import QpSolution, QpSolver
from llsrbm.control.solvers.program import Qp
from llsrbm.control.solvers.proxqp import ProxQp
from llsrbm.control.solvers.quadprog import Quadprog
from llsrbm.request.messages import look_up

__all__ = ["Qp", "QpSolution", "QpSolver", "check_name", "make_solver", "names"]

_SOLVERS: dict[str, type[QpSolver]] = {solver.name: solver for solver in (Quadprog, ProxQp)}


def names() -> tuple[str, ...]:
    """The solvers' names."""
    return tuple(_SOLVERS)


def check_name(name: str) -> None:
    """Raise `InputError`, naming the valid ones, for a name that is no QP solver's."""
    look_up("QP solver", name, _SOLVERS)


def make_solver(name: str) -> QpSolver:
    """The solver called `name`.

    Raises:
        InputError: no solver has that name.
    """
    return look_up("QP solver", name, _SOLVERS)()
