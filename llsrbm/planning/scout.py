"""Fast feasibility check of many tasks, each solved from a neighbour's solution.

A solve that succeeds from a near solution takes some tens of iterations; one that fails would go
on to the planner's limit. The scout's solver gives up early, which makes a failure as cheap as a
success, at the price of a few tasks at the very edge that patience would have solved.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import Cancelled
from llsrbm.jump import Jump
from llsrbm.motion.plan import Plan, Solution, SolveReport, Violation
from llsrbm.ocp.progress import attended
from llsrbm.ocp.solvers import HOPELESS, Fatrop
from llsrbm.ocp.stage_functions import constraints_of
from llsrbm.ocp.transcription import row_bounds
from llsrbm.planning.assembly import assemble_plan
from llsrbm.planning.guess import analytic_guess
from llsrbm.planning.knots import Knots, rolled_out, unpack
from llsrbm.planning.planner import HOMOTOPY, PATIENT_FLIGHT, Planner, scaled
from llsrbm.planning.residuals import satisfied, violations
from llsrbm.planning.task import Task, place_task

Array = NDArray[np.float64]

# Iterations from a neighbour; of 60 such solves that succeeded with more, five took more.
PATIENCE = 60
# Complementarity at which a solve from a neighbour starts: the neighbour's limits are active
# elsewhere, so more is undone than when a slider moves by a step.
MU_NEAR = 1e-3


@dataclass(frozen=True, eq=False)
class Found:
    """A task's solution.

    Attributes:
        solution: where a next solve may start.
        iterations, cost: of the solve that found it.
    """

    task: Task
    solution: Solution
    knots: Knots
    violations: dict[str, Violation]
    iterations: int
    cost: float


class OutOfTime(Exception):
    """The scout's budget is spent."""


class Scout:
    """Solves tasks of one planner's robot and model; counts what it does.

    Attributes:
        planner: whose problem it solves.
        about: what is looked for, for progress messages.
        solves, seconds: how often, and in how much wall time, so far.
        budget_s: after so much time a solve ends with `OutOfTime`.
    """

    def __init__(
        self,
        planner: Planner,
        progress: Callable[[str], None] | None = None,
        cancelled: Callable[[], bool] | None = None,
    ) -> None:
        """`progress` gets a text before each solve; `cancelled` is polled before and during it."""
        self.planner = planner
        self.about = ""
        self.solves, self.seconds = 0, 0.0
        self.budget_s = math.inf
        self._progress, self._cancelled = progress, cancelled
        self._cold = planner._backend._cold
        # Not while a solve that nobody waits for any more still runs: see `attended`.
        self._near = attended(
            lambda: _hurried(planner), look=lambda: None, tell=None, cancelled=cancelled
        )

    def solve(self, task: Task, near: Found | None = None) -> Found | None:
        """A task's solution from a neighbour's, or from the planner's guesses; None: not found.

        Raises:
            Cancelled: it is not wanted any more.
            OutOfTime: the budget is spent.
        """
        if near is not None:
            return self._run(self._near, task, self._moved(near, task))
        for flight_time in (None, PATIENT_FLIGHT):
            found = self._run(self._cold, task, self._guess(task, flight_time))
            if found is not None:
                return found
        return self._by_easier_jumps(task)

    def _by_easier_jumps(self, task: Task) -> Found | None:
        """Shares of the jump, each from the one before, under the task's limits."""
        robot, found = self.planner.robot, None
        for share in HOMOTOPY:
            easier = replace(
                place_task(scaled(task.jump, share), robot, task.tuning),
                limits=task.limits,
                reach=task.reach,
                timing=task.timing,
                foot=task.foot,
            )
            if found is None:
                found = self._run(self._cold, easier, self._guess(easier))
            else:
                found = self._run(self._near, easier, self._moved(found, easier))
            if found is None:
                return None
        return found

    def _run(self, solver: Any, task: Task, guess: Array) -> Found | None:
        if self.seconds > self.budget_s:
            raise OutOfTime
        self.solves += 1
        if self._cancelled is not None and self._cancelled():
            raise Cancelled("planning was cancelled")
        if self._progress is not None:
            self._progress(f"{self.about}, try {self.solves}")
        lower, upper = row_bounds(self.planner.layout, task)
        parameters = np.concatenate(list(task.parameters().values()))
        if self.planner._backend.miss(guess, parameters, (lower, upper)) > HOPELESS:
            return None
        start = time.perf_counter()
        result = attended(
            lambda: solver(x0=guess, p=parameters, lbg=lower, ubg=upper),
            look=lambda: None,
            tell=None,
            cancelled=self._cancelled,
        )
        self.seconds += time.perf_counter() - start
        stats = solver.stats()
        w = np.array(result["x"]).ravel()
        if not Fatrop.converged(stats):
            return None
        knots = rolled_out(unpack(w, self.planner.layout, task, self.planner.model))
        broken = violations(knots)
        if not satisfied(broken):
            return None
        iterations = int(stats["fatrop"]["iterations_count"])
        solution = Solution(w, np.array(result["lam_g"]).ravel())
        return Found(task, solution, knots, broken, iterations, float(result["f"]))

    def plan(self, found: Found) -> Plan:
        """The plan of a solution; its report counts everything the scout did."""

        def report() -> SolveReport:
            return SolveReport(
                status="solved",
                solver="fatrop",
                iterations=found.iterations,
                attempts=self.solves,
                solve_time_s=self.seconds,
                total_time_s=self.seconds,
                build_time_s=0.0,
                cost=found.cost,
            )

        return assemble_plan(
            found.task.jump,
            self.planner.robot,
            found.knots,
            found.violations,
            report,
            found.solution,
        )

    def _guess(self, task: Task, flight_time: float | None = None) -> Array:
        return analytic_guess(task, self.planner.layout, self.planner.model, flight_time)

    def _moved(self, near: Found, task: Task) -> Array:
        """A solution moved as the analytic guesses of the two tasks differ."""
        layout = self.planner.layout
        w = near.solution.variables + self._guess(task) - self._guess(near.task)
        for knot in range(layout.knots):
            place = layout.variables(knot).get("quat")
            if place is not None:
                w[place] /= np.linalg.norm(w[place])
        return w


def _hurried(planner: Planner) -> Any:
    """The planner's problem, which is at hand, in a Fatrop that gives up early."""
    solver = planner._backend._cold
    functions = {n: solver.get_function(n) for n in solver.get_function() if n.startswith("nlp_")}
    layout = planner.layout
    states = [layout.state_size(role) for role in layout.roles]
    task = place_task(Jump(robot=planner.robot.name), planner.robot)
    rows: list[int] = []
    equality: list[bool] = []
    for knot, role in enumerate(layout.roles):
        if not role.terminal:
            equality += [True] * states[knot + 1]
        start = len(equality)
        for constraint in constraints_of(role):
            lower, _ = np.broadcast_arrays(*constraint.bounds(task, layout, knot))
            equality += [constraint.equality] * len(lower)
        rows.append(len(equality) - start)
    options = {
        "print_time": False,
        "error_on_fail": False,
        "structure_detection": "manual",
        "N": layout.intervals.total,
        "nx": states,
        "nu": [layout.control_size(role) for role in layout.roles],
        "ng": rows,
        "equality": equality,
        "cache": functions,
        "fatrop": {
            "print_level": 0,
            "mu_init": MU_NEAR,
            "tolerance": 1e-4,
            "max_iter": PATIENCE,
        },
    }
    return ca.nlpsol("scout", "fatrop", solver.oracle(), options)
