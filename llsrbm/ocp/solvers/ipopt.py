"""Ipopt, a second opinion."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from llsrbm.ocp.problem import Iterate, Problem, Solution
from llsrbm.ocp.solvers.base import NEAR_MU, PATIENT, SolveOptions, Solver
from llsrbm.ocp.transcription import Transcribed

Array = NDArray[np.float64]


class Ipopt(Solver):
    """General interior point; slower, and an independent second opinion, so never compiled."""

    name = "ipopt"

    @classmethod
    def build(cls, transcription: Transcribed) -> Solver:
        """Build the solvers from guesses and near solutions."""
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

    def _with_options(self, options: SolveOptions) -> ca.Function:
        names = {"hess_lag": "nlp_hess_l", "jac_g": "nlp_jac_g", "grad_f": "nlp_grad_f"}
        derivatives = {option: self.function(name) for option, name in names.items()}
        return _ipopt(self.function("nlp"), derivatives, options, {})

    def _follow(
        self, problem: Problem, start: Iterate, rows: Array, acceptable: tuple[float, int] | None
    ) -> Solution:
        arguments = {
            "x0": start.variables,
            "lam_g0": start.multipliers,
            "p": problem.parameters,
            "lbg": problem.lower,
            "ubg": problem.upper,
        }
        return self._run(self._near[None], problem, arguments)

    def _outcome(self, stats: dict[str, Any]) -> tuple[bool, int]:
        return bool(stats["success"]), int(stats["iter_count"])


def _ipopt(
    nlp: ca.Function,
    derivatives: dict[str, ca.Function],
    options: SolveOptions,
    more: dict[str, Any],
) -> ca.Function:
    nlpsol_options = {
        "print_time": False,
        "error_on_fail": False,
        **derivatives,
        "ipopt": {
            "print_level": 0,
            "sb": "yes",
            "max_iter": options.iterations,
            "tol": options.tolerance,
            "constr_viol_tol": 1e-5,
            "mu_init": options.mu,
            **more,
        },
    }
    return ca.nlpsol("solver", "ipopt", nlp, nlpsol_options)
