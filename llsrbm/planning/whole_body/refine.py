"""A centroidal plan in, the whole body's plan near it out: solvers are built once and kept."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from llsrbm.motion.plan import Plan, Refinement, Violation
from llsrbm.ocp.horizon import Problem, Solution
from llsrbm.ocp.progress import interruptible, solving
from llsrbm.ocp.solvers import Fatrop, SolveOptions, Solver
from llsrbm.planning.solve.kept import kept
from llsrbm.planning.solve.solver_cache import Subject, cached_solver, is_compiling
from llsrbm.planning.solve.watch import Progress, Watch
from llsrbm.planning.whole_body.apart import Apart
from llsrbm.planning.whole_body.grid import Grid, Sizes
from llsrbm.planning.whole_body.motion import Motion
from llsrbm.planning.whole_body.problem import (
    make_horizon,
    make_problem,
    rows,
    unit_of_variables,
)
from llsrbm.planning.whole_body.result import plan_of
from llsrbm.planning.whole_body.start import Start, start_of, variables
from llsrbm.robots import load_robot
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)

# The guess is near: it begins where its bounds are, and where the cost is flat it is as good as
# solved. From a complementarity of 1e-3 one in 25 is not solved, and more iterations are needed.
OPTIONS = SolveOptions(mu=1e-4, iterations=7, push=0.01, acceptable=(5e-3, 4))
# After seven iterations most plans have rows that hold, and a cost within some per cent of the
# least, which some more would find; the others go on.
SOLVES = (OPTIONS, replace(OPTIONS, iterations=30), replace(OPTIONS, iterations=60))
TOLERANCE = 1e-3  # of rows, in their units of about 1
ROUNDS = 6  # of solves, each with the distances between links about the motion of the one before
SOLVED, FAILED = "solved", "not-converged"
_UNITS = {"stop": "rad", "rest": "m/s", "clearance": "m", "apart": "m"}


class Refiner:
    """The second stage of a robot's plans on one grid."""

    def __init__(self, robot: Robot, grid: Grid) -> None:
        """Load the solver from the cache, or build and keep it."""
        self.robot, self.grid, self.sizes = robot, grid, Sizes.of(robot)
        self.solver: Solver = cached_solver(Fatrop, _subject(robot, grid))
        self._unit = unit_of_variables(grid, self.sizes)
        self.solvers = (self.solver,)
        self.last: Motion | None = None  # of the last plan, for studies

    def refine(
        self,
        plan: Plan,
        *,
        cancelled: Callable[[], bool] | None = None,
        progress: Progress | None = None,
    ) -> Plan:
        """The whole body's plan near a centroidal one; that itself where there is none.

        Its `refinement` says which.

        Raises:
            Cancelled: `cancelled` was true.
        """
        begun, watch = time.perf_counter(), Watch(cancelled, progress)
        watch.wait()
        watch.begin("refining: the whole body's dynamics")
        start = start_of(plan, self.robot, self.grid)
        guess = variables(start, self.grid, self.sizes, self._unit)
        solutions: list[Solution] = []
        for _ in range(ROUNDS):
            problem = make_problem(self.robot, self.grid, start)
            for solution in self._solutions(problem, guess, watch):
                solutions.append(solution)
                found = self._violations(solution, problem, plan, start)
                # Where its rows hold a motion can be done, whether or not it is the nearest one.
                solved = all(violation.amount <= TOLERANCE for violation in found.values())
                if solved:
                    break
            if not solved:
                break
            motion = Motion.of(solution.variables, start.time[::2], self.grid, self.sizes)
            q, quat = motion.at(start.time).q, start.state["quat"]
            apart = Apart.near(q, start.time, quat, self.robot, start.solids, start.apart)
            if apart.holds:
                break
            start, guess = replace(start, apart=apart), solution.variables
        else:
            solved = False  # links meet still
        result = plan
        if solved:
            self.last = motion
            result = replace(
                plan_of(self.last, start, plan, self.robot, self.grid), violations=found
            )
        else:
            _log.info("the second stage did not converge: %s", solution.message)
        report = Refinement(
            status=SOLVED if solved else FAILED,
            iterations=sum(each.iterations for each in solutions),
            solve_time_s=sum(each.solve_time_s for each in solutions),
            total_time_s=time.perf_counter() - begun,
            build_time_s=0.0,
            cost=solution.cost,
            compiling=is_compiling(self.solver),
        )
        return replace(result, refinement=report)

    def _solutions(self, problem: Problem, guess: Array, watch: Watch) -> Iterator[Solution]:
        """Solutions of one problem, each with more patience from the one before."""
        for options in SOLVES:
            solution = watch.over(partial(self.solver.solve, problem, guess, options, watch.read))
            yield solution
            guess = solution.variables
            if not np.isfinite(guess).all():
                break

    def _violations(
        self, solution: Solution, problem: Problem, plan: Plan, start: Start
    ) -> dict[str, Violation]:
        """The largest violation of each kind of rows, of a solution as it is; NaN is the worst."""
        with solving:
            g = self.solver.function("nlp_g")(solution.variables, problem.parameters)
        g = np.array(g).ravel()
        found: dict[str, Violation] = {}
        at = 0
        for name, knot, instant, low, high in rows(self.robot, self.grid, start):
            values = g[at : at + len(low)]
            at += len(low)
            amount = float(np.max(np.maximum(low - values, values - high), initial=0.0))
            amount = amount if np.isfinite(amount) else np.inf
            name = name or "continuity"
            if name not in found or amount > found[name].amount:
                phase = int(self.grid.phase[min(knot, self.grid.intervals - 1)])
                named = plan.schedule[phase].name
                found[name] = Violation(amount, _UNITS.get(name, "1"), named, instant)
        return found


def refined(
    plan: Plan,
    robot: Robot | None = None,
    *,
    cancelled: Callable[[], bool] | None = None,
    progress: Progress | None = None,
) -> Plan:
    """`Refiner.refine` of a plan that converged, by a solver that is built once a process.

    `robot`: the one that the plan names, with other drives.
    """
    start = time.perf_counter()
    refiner = interruptible(partial(refiner_of, plan, robot), cancelled)
    built = time.perf_counter() - start
    result = refiner.refine(plan, cancelled=cancelled, progress=progress)
    assert result.refinement is not None
    return replace(result, refinement=replace(result.refinement, build_time_s=built))


def refiner_of(plan: Plan, robot: Robot | None = None) -> Refiner:
    """The second stage of plans like this one, built once and kept; `robot` as of `refined`."""
    robot = robot or load_robot(plan.jump.robot)
    own = robot.turning if plan.jump.turns else robot, Grid.of(plan)
    return kept((Refiner, *own), partial(Refiner, *own))


def _subject(robot: Robot, grid: Grid) -> Subject:
    return Subject(
        of=f"{robot.name}-whole-body",
        variant=grid.name,
        title=f"whole-body solver of {robot.name}",
        numbers=repr((robot.parameters(), robot.urdf.content, grid)),
        horizon=lambda: make_horizon(robot, grid),
    )
