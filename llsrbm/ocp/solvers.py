"""Interior-point solvers through CasADi's nlpsol, chosen by name; adding one is one class here."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import InputError
from llsrbm.motion.plan import Solution
from llsrbm.ocp.progress import IterationTable, printed_into
from llsrbm.ocp.transcription import Problem

Array = NDArray[np.float64]

MAX_ITERATIONS = 150
# Complementarity at which a solve starts from the analytic guess, which is far from the optimum.
MU_COLD = 1e-2
# How far a cold start is pushed inside of the bounds it touches; 15 % fewer iterations over ten
# jumps and three models than with the solver's default of 0.01.
BOUND_PUSH = 0.05

# Where the cost is flat Fatrop creeps: the constraints are met, the cost changes in the fourth
# digit, the gradient stays at some 1e-3. When that lasts, it is as good as solved.
ACCEPTABLE = 5e-3
ACCEPTABLE_ITERATIONS = 4

# A solve near a known solution stops at this tolerance: the cost is 0.02 % from that of a cold one.
NEAR_TOLERANCE = 3e-4
# The complementarity at which Fatrop ends for that tolerance; near a solution it begins there.
NEAR_MU = NEAR_TOLERANCE / 11
# Whoever is near is there in 2 to 10 iterations; a cold start is quicker than waiting for more.
NEAR_ITERATIONS = 15
# A solution that violates the rows of its neighbour by more, in their units of about 1, is none:
# Fatrop may not come back from there. A slider that moves by 30 deg makes 0.3.
TOO_FAR = 1.0
# Likewise of a guess: analytic ones violate rows by some 3.
HOPELESS = 100.0
# Of a row with two bounds only the one that is nearer by this ratio counts near a solution. Of 0.02
# to 1 this one loses the fewest solves, and moves the CoM of a solution by less than 0.4 mm.
NEARER = 0.05
# Scales of rows are the bounds' multipliers, not smaller than this: Fatrop sees scaled violations.
LEAST_SCALE = 1e-7

_STOPPED_ACCEPTABLE = 2  # Fatrop's return flag
_SILENT, _TABLE = 0, 5  # Fatrop's print levels


@dataclass(frozen=True, eq=False)
class Iterate:
    """Where a solver stopped.

    Attributes:
        w: all variables; multipliers: of all rows.
        converged: the solver's own word.
        iterations, cost, solve_time_s: of this solve.
        message: the solver's status.
    """

    w: Array
    multipliers: Array
    converged: bool
    iterations: int
    cost: float
    solve_time_s: float
    message: str

    @property
    def solution(self) -> Solution:
        """Where a next solve may start."""
        return Solution(self.w, self.multipliers)


class Backend(ABC):
    """An nlpsol plugin with its options: one solver starts from a guess, one near a solution."""

    name: ClassVar[str]

    def __init__(self, cold: ca.Function, near: ca.Function) -> None:
        self._cold, self._near = cold, near

    @property
    def sizes(self) -> tuple[int, int]:
        """Of the problem: numbers of variables and of rows."""
        return int(self._cold.numel_in("x0")), int(self._cold.numel_in("lbg"))

    @classmethod
    @abstractmethod
    def build(cls, problem: Problem) -> Backend:
        """Build the solvers of a problem."""

    @staticmethod
    def converged(stats: dict[str, Any]) -> bool:
        """From nlpsol's statistics."""
        return bool(stats["success"])

    @abstractmethod
    def _iterations(self, stats: dict[str, Any]) -> int:
        """From nlpsol's statistics."""

    def serialize(self) -> str:
        """The solvers as text, for the cache."""
        serializer = ca.StringSerializer()
        serializer.pack([self._cold, self._near])
        return str(serializer.encode())

    @classmethod
    def deserialize(cls, text: str) -> Backend:
        """The solvers that `serialize` wrote."""
        cold, near = ca.StringDeserializer(text).unpack()
        return cls(cold, near)

    def solve(
        self,
        guess: Array,
        parameters: Array,
        bounds: tuple[Array, Array],
        read: Callable[[str], None] | None = None,
    ) -> Iterate:
        """Solve from a guess; `read` takes the table of iterations, of solvers that print one."""
        if self.miss(guess, parameters, bounds) > HOPELESS:
            return self._given_up(Solution(guess, np.zeros_like(bounds[0])), parameters)
        arguments = {"x0": guess, "p": parameters, "lbg": bounds[0], "ubg": bounds[1]}
        with nullcontext() if read is None else self._printing(read):
            return self._run(self._cold, arguments)

    def miss(self, variables: Array, parameters: Array, bounds: tuple[Array, Array]) -> float:
        """The largest violation of a row; infinite where a row is not finite."""
        g = np.array(self._cold.get_function("nlp_g")(variables, parameters)).ravel()
        largest = np.maximum(bounds[0] - g, g - bounds[1]).max()
        return float(largest) if np.isfinite(largest) else math.inf

    def _given_up(self, start: Solution, parameters: Array) -> Iterate:
        """A solve that was not begun."""
        cost = float(self._cold.get_function("nlp_f")(start.variables, parameters))
        message = "too far from a solution to begin"
        return Iterate(start.variables, start.multipliers, False, 0, cost, 0.0, message)

    def _printing(self, read: Callable[[str], None]) -> AbstractContextManager[None]:
        """Meanwhile the solver prints its table into `read`; here it prints none."""
        return nullcontext()

    @abstractmethod
    def follow(self, start: Solution, parameters: Array, bounds: tuple[Array, Array]) -> Iterate:
        """Solve from the solution of a problem whose parameters and bounds are a little off."""

    def _run(self, solver: ca.Function, arguments: dict[str, Array]) -> Iterate:
        if not np.isfinite(arguments["x0"]).all():  # Fatrop would never return
            raise ValueError("the initial guess is not finite")
        start = time.perf_counter()
        result = solver(**arguments)
        elapsed = time.perf_counter() - start
        stats = solver.stats()
        return Iterate(
            w=np.array(result["x"]).ravel(),
            multipliers=np.array(result["lam_g"]).ravel(),
            converged=self.converged(stats),
            iterations=self._iterations(stats),
            cost=float(result["f"]),
            solve_time_s=elapsed,
            message=str(stats.get("return_status", "")),
        )


class Fatrop(Backend):
    """Structure-exploiting interior point (Riccati recursion over the stages); the default.

    It takes no multipliers to start from: those of bounds begin at 1, the others follow from them
    by least squares. So near a solution every row is scaled by its bound's multiplier z there: then
    1 is right, and the scaled slack is the complementarity z s, the same for all.
    """

    name = "fatrop"

    def __init__(self, cold: ca.Function, near: ca.Function) -> None:
        super().__init__(cold, near)
        _set_print_level(_SILENT)

    @contextmanager
    def _printing(self, read: Callable[[str], None]) -> Iterator[None]:
        _set_print_level(_TABLE)
        try:
            with printed_into(read):
                yield
        finally:
            _set_print_level(_SILENT)

    @classmethod
    def build(cls, problem: Problem) -> Backend:
        """See `Backend.build`."""
        functions = problem.functions
        # Its default tolerance of 1e-8 stalls; at 1e-4 the cost agrees to 0.1 %.
        cold = {
            "mu_init": MU_COLD,
            "tolerance": 1e-4,
            "max_iter": MAX_ITERATIONS,
            "bound_push": BOUND_PUSH,
            "bound_frac": BOUND_PUSH,
            "tol_acceptable": ACCEPTABLE,
            "acceptable_iter": ACCEPTABLE_ITERATIONS,
        }
        near = {
            "mu_init": NEAR_MU,
            "tolerance": NEAR_TOLERANCE,
            "max_iter": NEAR_ITERATIONS,
            "bound_push": NEAR_MU,
        }
        return cls(
            cls._nlpsol(problem, functions, cold),
            cls._nlpsol(problem, _with_scaled_rows(functions), near),
        )

    @staticmethod
    def _nlpsol(
        problem: Problem, functions: dict[str, ca.Function], options: dict[str, Any]
    ) -> ca.Function:
        structure = {
            "print_time": False,
            "error_on_fail": False,
            "structure_detection": "manual",
            "N": problem.layout.intervals.total,
            "nx": problem.state_sizes,
            "nu": problem.control_sizes,
            "ng": problem.row_counts,
            "equality": problem.equality.tolist(),
            "cache": {n: f for n, f in functions.items() if n != "nlp"},
            "fatrop": options,
        }
        return ca.nlpsol("planner", "fatrop", functions["nlp"], structure)

    def follow(self, start: Solution, parameters: Array, bounds: tuple[Array, Array]) -> Iterate:
        """See `Backend.follow`."""
        lower, upper = bounds
        inequality = lower < upper
        rows = self._cold.get_function("nlp_g")
        g = np.array(rows(start.variables, parameters)).ravel()
        if self.miss(start.variables, parameters, bounds) > TOO_FAR:
            return self._given_up(start, parameters)
        below, above = np.maximum(g - lower, 0.0), np.maximum(upper - g, 0.0)
        # A second bound far away would start at the multiplier 1 as well, far too much for it.
        lower = np.where(inequality & (above < NEARER * below), -np.inf, lower)
        upper = np.where(inequality & (below <= NEARER * above), np.inf, upper)
        scale = np.where(inequality, np.maximum(np.abs(start.multipliers), LEAST_SCALE), 1.0)
        iterate = self._run(
            self._near,
            {
                "x0": start.variables,
                "p": np.concatenate([parameters, scale]),
                "lbg": scale * lower,
                "ubg": scale * upper,
            },
        )
        return replace(iterate, multipliers=scale * iterate.multipliers)

    @staticmethod
    def converged(stats: dict[str, Any]) -> bool:
        """Within the tolerance, or `ACCEPTABLE` for long enough, which nlpsol does not count."""
        return bool(stats["success"]) or stats["fatrop"]["return_flag"] == _STOPPED_ACCEPTABLE

    def _iterations(self, stats: dict[str, Any]) -> int:
        return int(stats["fatrop"]["iterations_count"])


def _set_print_level(level: int) -> None:
    """Fatrop's print level is one for the whole process, set by whatever solver is new."""
    x = ca.SX.sym("x")
    options = {"print_time": False, "fatrop": {"print_level": level, "max_iter": 0}}
    with printed_into(IterationTable().read):
        ca.nlpsol("print_level", "fatrop", {"x": x, "f": x**2}, options)(x0=1.0)


def _with_scaled_rows(functions: dict[str, ca.Function]) -> dict[str, ca.Function]:
    """The same problem with every row of g times a parameter; these follow its own parameters."""
    jacobian = functions["nlp_jac_g"]
    pattern = jacobian.sparsity_out(1)
    rows = pattern.size1()
    x, lam_f = ca.MX.sym("x", pattern.size2()), ca.MX.sym("lam_f")
    lam, both = ca.MX.sym("lam_g", rows), ca.MX.sym("p", jacobian.numel_in(1) + rows)
    p, scale = ca.vertsplit(both, [0, jacobian.numel_in(1), both.numel()])
    g, J = jacobian(x, p)
    cost, df, unscaled = (functions[name](x, p) for name in ("nlp_f", "nlp_grad_f", "nlp_g"))
    _, H = functions["nlp_hess_l"](x, p, lam_f, scale * lam)
    _, _, slope, slope_p = functions["nlp_grad"](x, p, lam_f, scale * lam)
    results = {
        "nlp": [cost, scale * unscaled],
        "nlp_f": [cost],
        "nlp_g": [scale * unscaled],
        "nlp_grad_f": [df],
        "nlp_jac_g": [scale * g, ca.MX(pattern, J.nz[:] * scale.nz[pattern.row()])],
        "nlp_hess_l": [ca.MX(x.numel(), 1), H],
        "nlp_grad": [cost, scale * unscaled, slope, ca.vertcat(slope_p, ca.MX(rows, 1))],
    }
    arguments = [x, both, lam_f, lam]
    return {
        name: ca.Function(
            name,
            arguments[: functions[name].n_in()],
            outputs,
            functions[name].name_in(),
            functions[name].name_out(),
        )
        for name, outputs in results.items()
    }


class Ipopt(Backend):
    """General interior point; slower, and an independent second opinion."""

    name = "ipopt"

    @classmethod
    def build(cls, problem: Problem) -> Backend:
        """See `Backend.build`."""
        return cls(
            cls._nlpsol(problem, {"mu_init": MU_COLD}),
            cls._nlpsol(problem, {"mu_init": NEAR_MU, "warm_start_init_point": "yes"}),
        )

    @staticmethod
    def _nlpsol(problem: Problem, options: dict[str, Any]) -> ca.Function:
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
        oracle = {
            "print_time": False,
            "error_on_fail": False,
            "hess_lag": upper,
            "jac_g": functions["nlp_jac_g"],
            "grad_f": gradient,
            "ipopt": {
                "print_level": 0,
                "sb": "yes",
                "max_iter": MAX_ITERATIONS,
                "tol": 1e-4,
                "constr_viol_tol": 1e-5,
                **options,
            },
        }
        return ca.nlpsol("planner", "ipopt", functions["nlp"], oracle)

    def follow(self, start: Solution, parameters: Array, bounds: tuple[Array, Array]) -> Iterate:
        """See `Backend.follow`."""
        arguments = {"x0": start.variables, "lam_g0": start.multipliers, "p": parameters}
        return self._run(self._near, arguments | {"lbg": bounds[0], "ubg": bounds[1]})

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
