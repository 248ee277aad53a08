"""Ipopt, a second opinion."""

from dataclasses import replace
from typing import Any

import casadi as ca

from llsrbm.arrays import Array
from llsrbm.ocp.horizon import Iterate, Problem, Solution
from llsrbm.ocp.solvers.base import FROM_GUESS, NEAR_MU, SolveOptions, Solver


class Ipopt(Solver):
    """General interior point; slower, and an independent second opinion, so never compiled."""

    name = "ipopt"

    def _solver_from_guesses(self, options: SolveOptions) -> ca.Function:
        return self._nlpsol(options, {})

    def _solver_near(self, acceptable: tuple[float, int] | None) -> ca.Function:
        return self._nlpsol(replace(FROM_GUESS, mu=NEAR_MU), {"warm_start_init_point": "yes"})

    def _nlpsol(self, options: SolveOptions, more: dict[str, Any]) -> ca.Function:
        hessian = self.function("nlp_hess_l")
        arguments = [ca.MX.sym(hessian.name_in(i), hessian.sparsity_in(i)) for i in range(4)]
        upper = ca.Function(
            "nlp_hess_l",
            arguments,
            [ca.triu(hessian(*arguments)[1])],
            hessian.name_in(),
            ["triu_hess_gamma_x_x"],
        )
        x, p = arguments[:2]
        f, df = self.function("nlp_f")(x, p), self.function("nlp_grad_f")(x, p)
        gradient = ca.Function("nlp_grad_f", [x, p], [f, df], ["x", "p"], ["f", "grad_f_x"])
        nlpsol_options = {
            "print_time": False,
            "error_on_fail": False,
            "hess_lag": upper,
            "jac_g": self.function("nlp_jac_g"),
            "grad_f": gradient,
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
        return ca.nlpsol("solver", "ipopt", self.function("nlp"), nlpsol_options)

    def _follow(
        self, solver: ca.Function, problem: Problem, start: Iterate, rows: Array
    ) -> Solution:
        arguments = {"x0": start.variables, "lam_g0": start.multipliers}
        return self._run(solver, problem, arguments)

    def _outcome(self, stats: dict[str, Any]) -> tuple[bool, int]:
        return bool(stats["success"]), int(stats["iter_count"])
