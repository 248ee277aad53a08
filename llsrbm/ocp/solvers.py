"""Problem in, solution out: interior-point solvers through CasADi's nlpsol, chosen by name.

Adding one is one class here.
"""

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
from llsrbm.ocp.problem import Iterate, Problem, Solution
from llsrbm.ocp.progress import IterationTable, printed_into
from llsrbm.ocp.transcription import Structure, Transcribed

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Patience:
    """How a solve from a guess begins, and when it ends.

    Attributes:
        mu: complementarity at which it begins.
        iterations: after so many it is given up.
        tolerance: at which it has converged.
        push: how far it begins inside of the bounds it touches; None: Fatrop's own 0.01.
        within: size of rows, in their units of about 1, beyond which no step leads; None: anywhere.
        acceptable: where the cost is flat Fatrop creeps: the constraints are met, the cost changes
            in the fourth digit, the gradient stays at some 1e-3. At this tolerance, for so many
            iterations, it is as good as solved; None: it creeps on.

    Ipopt keeps its own ways with the last three, also near a solution.
    """

    mu: float
    iterations: int
    # Fatrop's default of 1e-8 stalls; at 1e-4 the cost agrees to 0.1 %.
    tolerance: float = 1e-4
    push: float | None = None
    within: float | None = None
    acceptable: tuple[float, int] | None = None


# From a guess, which is far from the optimum. The push takes 15 % fewer iterations over ten jumps
# and three models than with the solver's default.
PATIENT = Patience(mu=1e-2, iterations=150, push=0.05, acceptable=(5e-3, 4))

# A solve near a known solution stops at this tolerance: the cost is 0.02 % from that of a cold one.
NEAR_TOLERANCE = 3e-4
# The complementarity at which Fatrop ends for that tolerance; near a solution it begins there.
NEAR_MU = NEAR_TOLERANCE / 11
# Near starts converge in 2 to 10 iterations; a cold start is quicker than waiting for more.
NEAR_ITERATIONS = 15
# A solution that violates the rows of its neighbour by more, in their units of about 1, is none:
# Fatrop may not come back from there. A slider that moves by 30 deg makes 0.3.
TOO_FAR = 1.0
# Likewise of a guess: analytic ones violate rows by some 3.
HOPELESS = 100.0
# Rows of plans reach 5, SLIDER's 12. Where they grow, slopes grow faster, and Fatrop may look for a
# direction for ever: near a solution no step leads to rows beyond this.
WITHIN = 40.0
# Of a row with two bounds only the one that is nearer by this ratio counts near a solution. Of 0.02
# to 1 this one loses the fewest solves, and moves the CoM of a solution by less than 0.4 mm.
NEARER = 0.05
# Scales of rows are the bounds' multipliers, not smaller than this: Fatrop sees scaled violations.
LEAST_SCALE = 1e-7
# Multipliers of plans reach 22. Where rows leave next to no room they grow without bounds, 1e7 and
# more were seen of robots thrown up hard: scaled by these Fatrop looks for a direction for ever.
LARGEST_SCALE = 1e3

_NEAR_OPTIONS: dict[str, Any] = {
    "mu_init": NEAR_MU,
    "tolerance": NEAR_TOLERANCE,
    "max_iter": NEAR_ITERATIONS,
    "bound_push": NEAR_MU,
}
_STOPPED_ACCEPTABLE = 2  # Fatrop's return flag
_SILENT, _TABLE = 0, 5  # Fatrop's print levels


class Solver(ABC):
    """Solves a transcription's problems with one of nlpsol's plugins.

    Attributes:
        name: to choose it by.
        compiled: whether it takes compiled functions.
    """

    name: ClassVar[str]
    compiled: ClassVar[bool] = False

    def __init__(self, cold: ca.Function, near: ca.Function, structure: Structure) -> None:
        self._near, self._structure = near, structure
        self._cold = {PATIENT: cold}
        self._faster: Callable[[], Transcribed | None] | None = None
        self._wait: Callable[[], None] | None = None

    @property
    def sizes(self) -> tuple[int, int]:
        """Numbers of variables and of rows."""
        cold = self._cold[PATIENT]
        return int(cold.numel_in("x0")), int(cold.numel_in("lbg"))

    @classmethod
    @abstractmethod
    def build(cls, transcription: Transcribed) -> Solver:
        """Build the solver of a transcription."""

    def serialize(self) -> str:
        """The solver as text, for a cache."""
        serializer = ca.StringSerializer()
        structure = self._structure
        serializer.pack([self._cold[PATIENT], self._near])
        for sizes in (structure.states, structure.controls, structure.rows):
            serializer.pack(sizes)
        serializer.pack([int(equal) for equal in structure.equality])
        return str(serializer.encode())

    @classmethod
    def deserialize(cls, text: str) -> Solver:
        """The solver that `serialize` wrote."""
        serializer = ca.StringDeserializer(text)
        cold, near = serializer.unpack()
        # Whole numbers come back as floats.
        states, controls, rows, equality = ([int(n) for n in serializer.unpack()] for _ in range(4))
        return cls(cold, near, Structure(states, controls, rows, [bool(n) for n in equality]))

    def replace_by(
        self, faster: Callable[[], Transcribed | None], wait: Callable[[], None] | None = None
    ) -> None:
        """Take the same problem's faster functions in the next solve in which they are there.

        Args:
            faster: gives them, or None as long as there are none.
            wait: returns when they are there, or will never be.
        """
        self._faster, self._wait = faster, wait

    def settle(self) -> None:
        """Wait for faster functions that are being made; solves before and after take the same."""
        if self._faster is not None and self._wait is not None:
            self._wait()
        self._renew()
        self._faster = None

    def _renew(self) -> None:
        if self._faster is None or (transcribed := self._faster()) is None:
            return
        new = type(self).build(transcribed)
        self._cold, self._near, self._faster = new._cold, new._near, None

    def function(self, name: str) -> ca.Function:
        """One of the problem's functions, as it is evaluated: nlp_f, nlp_g, ...; nlp: f and g."""
        cold = self._cold[PATIENT]
        return cold.oracle() if name == "nlp" else cold.get_function(name)

    def solve(
        self,
        problem: Problem,
        guess: Array,
        patience: Patience = PATIENT,
        read: Callable[[str], None] | None = None,
    ) -> Solution:
        """Solve from a guess.

        Args:
            problem: its numbers.
            guess: all variables.
            patience: how long to go on.
            read: takes the table of iterations, of solvers that print one.
        """
        self._renew()
        if (miss := self.miss(problem, guess)) > HOPELESS:
            return self._given_up(problem, Iterate(guess, np.zeros_like(problem.lower)), miss)
        if patience not in self._cold:
            self._cold[patience] = self._another(patience)
        arguments = {
            "x0": guess,
            "p": problem.parameters,
            "lbg": problem.lower,
            "ubg": problem.upper,
        }
        with nullcontext() if read is None else self._printing(read):
            return self._run(self._cold[patience], problem, arguments)

    def follow(
        self,
        problem: Problem,
        start: Iterate,
        too_far: float = TOO_FAR,
        acceptable: tuple[float, int] | None = None,
    ) -> Solution:
        """Solve from the solution of a problem whose numbers are a little off.

        Args:
            problem: its numbers.
            start: the solution.
            too_far: largest violation of a row with which it is begun.
            acceptable: as of `Patience`.
        """
        self._renew()
        rows = self._rows(problem, start.variables)
        if (miss := _largest_violation(problem, rows)) > too_far:
            return self._given_up(problem, start, miss)
        return self._follow(problem, start, rows, acceptable)

    @abstractmethod
    def _follow(
        self, problem: Problem, start: Iterate, rows: Array, acceptable: tuple[float, int] | None
    ) -> Solution:
        """See `follow`; `rows` (rows,): g of the start."""

    def miss(self, problem: Problem, variables: Array) -> float:
        """The largest violation of a row; infinite where a row is not finite."""
        return _largest_violation(problem, self._rows(problem, variables))

    def _rows(self, problem: Problem, variables: Array) -> Array:
        return np.array(self.function("nlp_g")(variables, problem.parameters)).ravel()

    def _given_up(self, problem: Problem, start: Iterate, miss: float) -> Solution:
        """A solve that was not begun."""
        f = self._cold[PATIENT].get_function("nlp_f")
        return Solution(
            variables=start.variables,
            multipliers=start.multipliers,
            converged=False,
            iterations=0,
            cost=float(f(start.variables, problem.parameters)),
            solve_time_s=0.0,
            violation=miss,
            message="too far from a solution to begin",
        )

    @abstractmethod
    def _another(self, patience: Patience) -> ca.Function:
        """The solver from guesses with another patience; the functions are at hand."""

    @abstractmethod
    def _converged(self, stats: dict[str, Any]) -> bool:
        """From nlpsol's statistics."""

    @abstractmethod
    def _iterations(self, stats: dict[str, Any]) -> int:
        """From nlpsol's statistics."""

    def _printing(self, read: Callable[[str], None]) -> AbstractContextManager[None]:
        """Meanwhile the solver prints its table into `read`; here it prints none."""
        return nullcontext()

    def _run(
        self,
        solver: ca.Function,
        problem: Problem,
        arguments: dict[str, Array],
        scale: float | Array = 1.0,
    ) -> Solution:
        """Run one; `scale` (rows,): of its rows, in units of the problem's."""
        if not np.isfinite(arguments["x0"]).all():  # Fatrop would never return
            raise ValueError("the initial guess is not finite")
        start = time.perf_counter()
        result = solver(**arguments)
        elapsed = time.perf_counter() - start
        stats = solver.stats()
        return Solution(
            variables=np.array(result["x"]).ravel(),
            multipliers=scale * np.array(result["lam_g"]).ravel(),
            converged=self._converged(stats),
            iterations=self._iterations(stats),
            cost=float(result["f"]),
            solve_time_s=elapsed,
            violation=_largest_violation(problem, np.array(result["g"]).ravel() / scale),
            message=str(stats.get("return_status", "")),
        )


def _largest_violation(problem: Problem, g: Array) -> float:
    largest = np.maximum(problem.lower - g, g - problem.upper).max()
    return float(largest) if np.isfinite(largest) else math.inf


class Fatrop(Solver):
    """Structure-exploiting interior point (Riccati recursion over the stages); the default.

    It takes no multipliers to start from: those of bounds begin at 1, the others follow from them
    by least squares. So near a solution every row is scaled by its bound's multiplier z there: then
    1 is right, and the scaled slack is the complementarity z s, the same for all.
    """

    name = "fatrop"
    compiled = True

    def __init__(self, cold: ca.Function, near: ca.Function, structure: Structure) -> None:
        super().__init__(cold, near, structure)
        self._creeping: dict[tuple[float, int], ca.Function] = {}  # near ones that stop earlier
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
    def build(cls, transcription: Transcribed) -> Solver:
        """See `Solver.build`."""
        functions, structure = transcription.functions, transcription.structure
        return cls(
            _fatrop(functions, structure, _fatrop_options(PATIENT)),
            _fatrop(_with_scaled_rows(functions), structure, _NEAR_OPTIONS),
            structure,
        )

    def _renew(self) -> None:
        before = self._near
        super()._renew()
        if self._near is not before:
            self._creeping.clear()

    def _functions(self) -> dict[str, ca.Function]:
        available = self._cold[PATIENT].get_function()
        functions = {n: self.function(n) for n in available if n.startswith("nlp_")}
        return functions | {"nlp": self.function("nlp")}

    def _another(self, patience: Patience) -> ca.Function:
        functions = self._functions()
        if patience.within is not None:
            functions["nlp_g"] = _rows_within(functions["nlp_g"], patience.within)
        options = _fatrop_options(patience) | {"print_level": _SILENT}
        return _fatrop(functions, self._structure, options)

    def _near_until(self, acceptable: tuple[float, int] | None) -> ca.Function:
        if acceptable is None:
            return self._near
        if acceptable not in self._creeping:
            options = _NEAR_OPTIONS | _acceptable_options(acceptable) | {"print_level": _SILENT}
            scaled = _with_scaled_rows(self._functions())
            self._creeping[acceptable] = _fatrop(scaled, self._structure, options)
        return self._creeping[acceptable]

    def _follow(
        self, problem: Problem, start: Iterate, rows: Array, acceptable: tuple[float, int] | None
    ) -> Solution:
        """See `Solver.follow`."""
        lower, upper = problem.lower, problem.upper
        inequality = lower < upper
        below, above = np.maximum(rows - lower, 0.0), np.maximum(upper - rows, 0.0)
        # A second bound far away would start at the multiplier 1 as well, far too much for it.
        lower = np.where(inequality & (above < NEARER * below), -np.inf, lower)
        upper = np.where(inequality & (below <= NEARER * above), np.inf, upper)
        scale = np.where(inequality, np.maximum(np.abs(start.multipliers), LEAST_SCALE), 1.0)
        if not scale.max() <= LARGEST_SCALE:
            return self._given_up(problem, start, _largest_violation(problem, rows))
        arguments = {
            "x0": start.variables,
            "p": np.concatenate([problem.parameters, scale]),
            "lbg": scale * lower,
            "ubg": scale * upper,
        }
        return self._run(self._near_until(acceptable), problem, arguments, scale)

    def _converged(self, stats: dict[str, Any]) -> bool:
        """Within the tolerance, or acceptable for long enough, which nlpsol does not count."""
        return bool(stats["success"]) or stats["fatrop"]["return_flag"] == _STOPPED_ACCEPTABLE

    def _iterations(self, stats: dict[str, Any]) -> int:
        return int(stats["fatrop"]["iterations_count"])


def _fatrop_options(patience: Patience) -> dict[str, Any]:
    options: dict[str, Any] = {
        "mu_init": patience.mu,
        "tolerance": patience.tolerance,
        "max_iter": patience.iterations,
    }
    if patience.push is not None:
        options |= {"bound_push": patience.push, "bound_frac": patience.push}
    if patience.acceptable is not None:
        options |= _acceptable_options(patience.acceptable)
    return options


def _acceptable_options(acceptable: tuple[float, int]) -> dict[str, Any]:
    tolerance, iterations = acceptable
    return {"tol_acceptable": tolerance, "acceptable_iter": iterations}


def _fatrop(
    functions: dict[str, ca.Function], structure: Structure, options: dict[str, Any]
) -> ca.Function:
    nlpsol_options = {
        "print_time": False,
        "error_on_fail": False,
        "show_eval_warnings": False,  # of rows that are no numbers on purpose
        "structure_detection": "manual",
        "N": len(structure.states) - 1,
        "nx": structure.states,
        "nu": structure.controls,
        "ng": structure.rows,
        "equality": structure.equality,
        "cache": {n: f for n, f in functions.items() if n != "nlp"},
        "fatrop": options,
    }
    return ca.nlpsol("solver", "fatrop", functions["nlp"], nlpsol_options)


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
        "nlp_g": [scale * _no_number_beyond(unscaled, WITHIN)],
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


def _no_number_beyond(rows: ca.MX, within: float) -> ca.MX:
    """Rows, or none that is a number where one of them is larger: line searches step back there."""
    return rows / (ca.norm_inf(rows) <= within)


def _rows_within(rows: ca.Function, within: float) -> ca.Function:
    x, p = (ca.MX.sym(rows.name_in(i), rows.sparsity_in(i)) for i in range(2))
    tamed = _no_number_beyond(rows(x, p), within)
    return ca.Function(rows.name(), [x, p], [tamed], rows.name_in(), rows.name_out())


class Ipopt(Solver):
    """General interior point; slower, and an independent second opinion, so never compiled."""

    name = "ipopt"

    @classmethod
    def build(cls, transcription: Transcribed) -> Solver:
        """See `Solver.build`."""
        functions = transcription.functions
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
        derivatives = {"hess_lag": upper, "jac_g": functions["nlp_jac_g"], "grad_f": gradient}
        near = replace(PATIENT, mu=NEAR_MU)
        return cls(
            _ipopt(functions["nlp"], derivatives, PATIENT, {}),
            _ipopt(functions["nlp"], derivatives, near, {"warm_start_init_point": "yes"}),
            transcription.structure,
        )

    def _another(self, patience: Patience) -> ca.Function:
        names = {"hess_lag": "nlp_hess_l", "jac_g": "nlp_jac_g", "grad_f": "nlp_grad_f"}
        derivatives = {option: self.function(name) for option, name in names.items()}
        return _ipopt(self.function("nlp"), derivatives, patience, {})

    def _follow(
        self, problem: Problem, start: Iterate, rows: Array, acceptable: tuple[float, int] | None
    ) -> Solution:
        """See `Solver.follow`."""
        arguments = {
            "x0": start.variables,
            "lam_g0": start.multipliers,
            "p": problem.parameters,
            "lbg": problem.lower,
            "ubg": problem.upper,
        }
        return self._run(self._near, problem, arguments)

    def _converged(self, stats: dict[str, Any]) -> bool:
        return bool(stats["success"])

    def _iterations(self, stats: dict[str, Any]) -> int:
        return int(stats["iter_count"])


def _ipopt(
    nlp: ca.Function,
    derivatives: dict[str, ca.Function],
    patience: Patience,
    options: dict[str, Any],
) -> ca.Function:
    nlpsol_options = {
        "print_time": False,
        "error_on_fail": False,
        **derivatives,
        "ipopt": {
            "print_level": 0,
            "sb": "yes",
            "max_iter": patience.iterations,
            "tol": patience.tolerance,
            "constr_viol_tol": 1e-5,
            "mu_init": patience.mu,
            **options,
        },
    }
    return ca.nlpsol("solver", "ipopt", nlp, nlpsol_options)


_SOLVERS: dict[str, type[Solver]] = {solver.name: solver for solver in (Fatrop, Ipopt)}


def names() -> tuple[str, ...]:
    """The solvers' names, the default first."""
    return tuple(_SOLVERS)


def by_name(name: str) -> type[Solver]:
    """The solver called `name`.

    Raises:
        InputError: no solver has that name.
    """
    if name not in _SOLVERS:
        raise InputError(f"unknown solver {name!r}; the solvers are {', '.join(_SOLVERS)}")
    return _SOLVERS[name]
