"""Interior-point solvers through CasADi's nlpsol, chosen by name; adding one is one class here."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import InputError
from llsrbm.planning.transcription import Problem

Array = NDArray[np.float64]

MAX_ITERATIONS = 150
# Complementarity at which a solve starts: the analytic guess is far from the optimum, the previous
# plan is close to it.
MU_COLD, MU_WARM = 1e-2, 1e-4
# How far a cold start is pushed inside of the bounds it touches; 15 % fewer iterations over ten
# jumps and three models than with the solver's default of 0.01.
BOUND_PUSH = 0.05


@dataclass(frozen=True, eq=False)
class Iterate:
    """Where a solver stopped.

    Attributes:
        w: all variables.
        converged: the solver's own word.
        iterations, cost, solve_time_s: of this solve.
        message: the solver's status.
    """

    w: Array
    converged: bool
    iterations: int
    cost: float
    solve_time_s: float
    message: str


class Backend(ABC):
    """An nlpsol plugin with its options; cold and warm starts are two instances of one problem."""

    name: ClassVar[str]

    def __init__(self, cold: ca.Function, warm: ca.Function) -> None:
        self._cold, self._warm = cold, warm

    @classmethod
    def build(cls, problem: Problem) -> Backend:
        """Build both solvers of a problem."""
        return cls(*(cls._nlpsol(problem, mu) for mu in (MU_COLD, MU_WARM)))

    @classmethod
    @abstractmethod
    def _nlpsol(cls, problem: Problem, mu: float) -> ca.Function:
        """The solver that starts at complementarity mu."""

    @abstractmethod
    def _iterations(self, stats: dict[str, Any]) -> int:
        """From nlpsol's statistics."""

    def serialize(self) -> str:
        """Both solvers as text, for the cache."""
        serializer = ca.StringSerializer()
        serializer.pack([self._cold, self._warm])
        return str(serializer.encode())

    @classmethod
    def deserialize(cls, text: str) -> Backend:
        """The solvers that `serialize` wrote."""
        cold, warm = ca.StringDeserializer(text).unpack()
        return cls(cold, warm)

    def solve(
        self, guess: Array, parameters: Array, bounds: tuple[Array, Array], warm: bool
    ) -> Iterate:
        """Solve from a guess; `warm` says that it is near a solution, so that little is undone."""
        if not np.isfinite(guess).all():  # Fatrop would never return
            raise ValueError("the initial guess is not finite")
        solver = self._warm if warm else self._cold
        arguments = {"x0": guess, "p": parameters, "lbg": bounds[0], "ubg": bounds[1]}
        start = time.perf_counter()
        result = solver(**arguments)
        elapsed = time.perf_counter() - start
        stats = solver.stats()
        return Iterate(
            w=np.array(result["x"]).ravel(),
            converged=bool(stats["success"]),
            iterations=self._iterations(stats),
            cost=float(result["f"]),
            solve_time_s=elapsed,
            message=str(stats.get("return_status", "")),
        )


class Fatrop(Backend):
    """Structure-exploiting interior point (Riccati recursion over the stages); the default."""

    name = "fatrop"

    @classmethod
    def _nlpsol(cls, problem: Problem, mu: float) -> ca.Function:
        functions = problem.functions
        push = {} if mu < MU_COLD else {"bound_push": BOUND_PUSH, "bound_frac": BOUND_PUSH}
        options = {
            "print_time": False,
            "error_on_fail": False,
            "structure_detection": "manual",
            "N": problem.layout.intervals.total,
            "nx": problem.state_sizes,
            "nu": problem.control_sizes,
            "ng": problem.row_counts,
            "equality": problem.equality.tolist(),
            "cache": {n: f for n, f in functions.items() if n != "nlp"},
            # Its default tolerance of 1e-8 stalls; at 1e-4 the cost agrees to 0.1 %.
            "fatrop": {
                "print_level": 0,
                "mu_init": mu,
                "tolerance": 1e-4,
                "max_iter": MAX_ITERATIONS,
                **push,
            },
        }
        return ca.nlpsol("planner", "fatrop", functions["nlp"], options)

    def _iterations(self, stats: dict[str, Any]) -> int:
        return int(stats["fatrop"]["iterations_count"])


class Ipopt(Backend):
    """General interior point; slower, and an independent second opinion."""

    name = "ipopt"

    @classmethod
    def _nlpsol(cls, problem: Problem, mu: float) -> ca.Function:
        functions = problem.functions
        hessian = functions["nlp_hess_l"]
        arguments = [ca.MX.sym(hessian.name_in(i), hessian.sparsity_in(i)) for i in range(4)]
        upper = ca.Function(
            "nlp_hess_l",
            arguments,
            [ca.triu(hessian(*arguments)[1])],
            hessian.name_in(),
            ["triu_hess_gamma_x_x"],
        )
        x, p = arguments[:2]
        f, df = functions["nlp_f"](x, p), functions["nlp_grad_f"](x, p)
        gradient = ca.Function("nlp_grad_f", [x, p], [f, df], ["x", "p"], ["f", "grad_f_x"])
        warm = mu < MU_COLD
        options = {
            "print_time": False,
            "error_on_fail": False,
            "hess_lag": upper,
            "jac_g": functions["nlp_jac_g"],
            "grad_f": gradient,
            "ipopt": {
                "print_level": 0,
                "sb": "yes",
                "max_iter": MAX_ITERATIONS,
                "mu_init": mu,
                "tol": 1e-4,
                "constr_viol_tol": 1e-5,
                "warm_start_init_point": "yes" if warm else "no",
            },
        }
        return ca.nlpsol("planner", "ipopt", functions["nlp"], options)

    def _iterations(self, stats: dict[str, Any]) -> int:
        return int(stats["iter_count"])


_BACKENDS: dict[str, type[Backend]] = {backend.name: backend for backend in (Fatrop, Ipopt)}


def names() -> tuple[str, ...]:
    """The solvers' names, the default first."""
    return tuple(_BACKENDS)


def backend(name: str) -> type[Backend]:
    """The solver called `name`.

    Raises:
        InputError: no solver has that name.
    """
    if name not in _BACKENDS:
        raise InputError(f"unknown solver {name!r}; the solvers are {', '.join(_BACKENDS)}")
    return _BACKENDS[name]
