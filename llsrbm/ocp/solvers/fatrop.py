"""Fatrop, which exploits the stages, and how it is made to start from a near solution."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.ocp import fatrop_patches
from llsrbm.ocp.fatrop_patches import LARGEST_SCALE, WITHIN
from llsrbm.ocp.horizon import Iterate, Problem, Solution
from llsrbm.ocp.progress import printed_into
from llsrbm.ocp.solvers.base import NEAR_MU, NEAR_TOLERANCE, SolveOptions, Solver, largest_violation
from llsrbm.ocp.transcription import Transcribed

# Near starts converge in 2 to 10 iterations; a cold start is quicker than waiting for more.
NEAR_ITERATIONS = 15
# Of a row with two bounds only the one that is nearer by this ratio counts near a solution. Of 0.02
# to 1 this one loses the fewest solves, and moves the CoM of a solution by less than 0.4 mm.
NEARER = 0.05
# Rows that begin large, as squared distances do, may grow by this factor.
GROWTH = 2.0
# Scales of rows are the bounds' multipliers, not smaller than this: Fatrop sees scaled violations.
LEAST_SCALE = 1e-7

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

    def __init__(self, transcribed: Transcribed) -> None:
        super().__init__(transcribed)
        _set_print_level(_SILENT)

    @contextmanager
    def _printing(self, read: Callable[[str], None]) -> Iterator[None]:
        _set_print_level(_TABLE)
        try:
            with printed_into(read):
                yield
        finally:
            _set_print_level(_SILENT)

    def _solver_from_guesses(self, options: SolveOptions) -> ca.Function:
        functions = dict(self._problem.functions)
        if options.within is not None:
            functions["nlp_g"] = _rows_within(functions["nlp_g"], options.within)
        chosen: dict[str, Any] = {"mu_init": options.mu, "tolerance": options.tolerance}
        chosen["max_iter"] = options.iterations
        if options.push is not None:
            chosen |= dict.fromkeys(("bound_push", "bound_frac"), options.push)
        return self._nlpsol(functions, chosen, options.acceptable)

    def _solver_near(self, acceptable: tuple[float, int] | None) -> ca.Function:
        functions = _with_scaled_rows(self._problem.functions)
        return self._nlpsol(functions, _NEAR_OPTIONS, acceptable)

    def _nlpsol(
        self,
        functions: dict[str, ca.Function],
        options: dict[str, Any],
        acceptable: tuple[float, int] | None,
    ) -> ca.Function:
        structure = self._problem.structure
        if acceptable is not None:
            tolerance, iterations = acceptable
            options = options | {"tol_acceptable": tolerance, "acceptable_iter": iterations}
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
            "fatrop": options,  # without a print level: the first solve would set it
        }
        return ca.nlpsol("solver", "fatrop", functions["nlp"], nlpsol_options)

    def _follow(
        self, solver: ca.Function, problem: Problem, start: Iterate, rows: Array
    ) -> Solution:
        lower, upper = problem.lower, problem.upper
        inequality = lower < upper
        below, above = np.maximum(rows - lower, 0.0), np.maximum(upper - rows, 0.0)
        # A second bound far away would start at the multiplier 1 as well, far too much for it.
        lower = np.where(inequality & (above < NEARER * below), -np.inf, lower)
        upper = np.where(inequality & (below <= NEARER * above), np.inf, upper)
        scale = np.where(inequality, np.maximum(np.abs(start.multipliers), LEAST_SCALE), 1.0)
        if not scale.max() <= LARGEST_SCALE:
            return self._not_begun(problem, start, largest_violation(problem, rows))
        within = max(WITHIN, GROWTH * np.abs(rows).max())
        arguments = {
            "x0": start.variables,
            "p": np.concatenate([problem.parameters, scale, [within]]),
            "lbg": scale * lower,
            "ubg": scale * upper,
        }
        return self._run(solver, problem, arguments, scale)

    @property
    def gives_up(self) -> bool:
        """True with the patches that make it do so."""
        return fatrop_patches.is_loaded()

    def _outcome(self, stats: dict[str, Any]) -> tuple[bool, int]:
        fatrop = stats["fatrop"]  # nlpsol does not count what is acceptable as a success
        converged = stats["success"] or fatrop["return_flag"] == _STOPPED_ACCEPTABLE
        return bool(converged), int(fatrop["iterations_count"])


def _set_print_level(level: int) -> None:
    """Set Fatrop's print level, one for the whole process, by a new solver."""
    x = ca.SX.sym("x")
    options = {"print_time": False, "fatrop": {"print_level": level, "max_iter": 0}}
    with printed_into(lambda _: None):
        ca.nlpsol("print_level", "fatrop", {"x": x, "f": x**2}, options)(x0=1.0)


def _with_scaled_rows(functions: dict[str, ca.Function]) -> dict[str, ca.Function]:
    """The same problem with every row of g times a parameter, and no number where one is too large.

    Scales follow its own parameters; the size of rows beyond which g is no number is the last one.
    """
    jacobian = functions["nlp_jac_g"]
    pattern = jacobian.sparsity_out(1)
    rows = pattern.size1()
    x, lam_f = ca.MX.sym("x", pattern.size2()), ca.MX.sym("lam_f")
    own = jacobian.numel_in(1)
    lam, all_p = ca.MX.sym("lam_g", rows), ca.MX.sym("p", own + rows + 1)
    p, scale, within = ca.vertsplit(all_p, [0, own, own + rows, own + rows + 1])
    g, J = jacobian(x, p)
    cost, df, unscaled = (functions[name](x, p) for name in ("nlp_f", "nlp_grad_f", "nlp_g"))
    _, H = functions["nlp_hess_l"](x, p, lam_f, scale * lam)
    _, _, slope, slope_p = functions["nlp_grad"](x, p, lam_f, scale * lam)
    results = {
        "nlp": [cost, scale * unscaled],
        "nlp_f": [cost],
        "nlp_g": [scale * _no_number_beyond(unscaled, within)],
        "nlp_grad_f": [df],
        "nlp_jac_g": [scale * g, ca.MX(pattern, J.nz[:] * scale.nz[pattern.row()])],
        "nlp_hess_l": [ca.MX(x.numel(), 1), H],
        "nlp_grad": [cost, scale * unscaled, slope, ca.vertcat(slope_p, ca.MX(rows + 1, 1))],
    }
    arguments = [x, all_p, lam_f, lam]
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


def _no_number_beyond(rows: ca.MX, within: float | ca.MX) -> ca.MX:
    """Rows, or none that is a number where one of them is larger: line searches step back there."""
    return rows / (ca.norm_inf(rows) <= within)


def _rows_within(rows: ca.Function, within: float) -> ca.Function:
    x, p = (ca.MX.sym(rows.name_in(i), rows.sparsity_in(i)) for i in range(2))
    compressed = _no_number_beyond(rows(x, p), within)
    return ca.Function(rows.name(), [x, p], [compressed], rows.name_in(), rows.name_out())
