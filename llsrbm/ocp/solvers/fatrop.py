"""Fatrop, which exploits the stages, and how it is made to start from a near solution."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from llsrbm.ocp.problem import Iterate, Problem, Solution
from llsrbm.ocp.progress import IterationTable, printed_into
from llsrbm.ocp.solvers.base import (
    NEAR_MU,
    NEAR_TOLERANCE,
    PATIENT,
    Patience,
    Solver,
    largest_violation,
)
from llsrbm.ocp.transcription import Structure, Transcribed

Array = NDArray[np.float64]

# Near starts converge in 2 to 10 iterations; a cold start is quicker than waiting for more.
NEAR_ITERATIONS = 15
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
            return self._given_up(problem, start, largest_violation(problem, rows))
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
