"""Fast feasibility check of many tasks, each solved from a neighbour's solution.

A solve that succeeds from a near solution takes some tens of iterations; one that fails would go
on to the planner's limit. A hurried solve gives up early, which makes a failure as cheap as a
success, at the price of a few tasks at the very edge that a longer solve would find.
"""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import NDArray

from llsrbm.motion.plan import Plan
from llsrbm.ocp.solvers import PATIENT, SolveOptions
from llsrbm.planning.problem.task import Task
from llsrbm.planning.solve.formulation import PATIENT_FLIGHT, Attempt, Formulation
from llsrbm.planning.solve.progress import Watch

Array = NDArray[np.float64]

# From a neighbour's solution. Its limits are active elsewhere, so more is undone than when a slider
# moves by a step: hence the complementarity. Of 60 such solves that succeeded with more iterations,
# five took more.
HURRIED = SolveOptions(mu=1e-3, iterations=60)


class OutOfTime(Exception):
    """The budget is spent."""


class FeasibilitySearch:
    """Solves tasks of one robot and model; counts what it does.

    Attributes:
        formulation: what it solves, and with what.
        about: the search's aim, for progress messages.
        solves, seconds: number of solves so far, and the time in the solver.
        deadline: of `time.monotonic`, s; no solve begins after it.
    """

    def __init__(self, formulation: Formulation, watch: Watch | None = None) -> None:
        """Solve nothing yet; `watch` reports progress and may cancel.

        Raises:
            Cancelled: it is not wanted any more.
        """
        self.formulation = formulation
        self.about = ""
        self.solves, self.seconds = 0, 0.0
        self.deadline, self._begun = math.inf, time.perf_counter()
        self._watch = Watch() if watch is None else watch
        self._watch.wait()

    def solve(self, task: Task, near: Attempt | None = None) -> Attempt | None:
        """A task's solution from a neighbour's, or from the planner's guesses; None: not found.

        Raises:
            Cancelled: it is not wanted any more.
            OutOfTime: the deadline has passed.
        """
        formulation = self.formulation
        if near is not None:
            return self._run(task, formulation.moved(near, task), HURRIED)
        for flight_time in (None, PATIENT_FLIGHT):
            found = self._run(task, formulation.guess(task, flight_time), PATIENT)
            if found is not None:
                return found
        return self._by_easier_jumps(task)

    def _by_easier_jumps(self, task: Task) -> Attempt | None:
        """Shares of the jump, each from the one before, under the task's limits."""
        found = None
        for easier in self.formulation.easier(task):
            if found is None:
                found = self._run(easier, self.formulation.guess(easier), PATIENT)
            else:
                found = self._run(easier, self.formulation.moved(found, easier), HURRIED)
            if found is None:
                return None
        return found

    def _run(self, task: Task, guess: Array, options: SolveOptions) -> Attempt | None:
        if time.monotonic() > self.deadline:
            raise OutOfTime
        self.solves += 1
        self._watch.begin(f"{self.about}, try {self.solves}")
        attempt = self.formulation.solve(task, guess, self._watch, options)
        attempt = self.formulation.agreed(attempt, self._watch)
        self.seconds += attempt.solution.solve_time_s
        return attempt if attempt.solved else None

    def plan(self, found: Attempt) -> Plan:
        """The plan of a solution; its report counts the whole search."""
        return self.formulation.plan(found, self.solves, self.seconds, self._begun)
