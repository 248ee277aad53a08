"""Request in, plan out: one warm solver for each robot, model, solver and number of intervals."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property, lru_cache

from llsrbm.errors import InputError, NotConverged, UnusableStart
from llsrbm.models import check_name, make_model
from llsrbm.models.base import CentroidalModel
from llsrbm.motion.plan import Plan
from llsrbm.ocp import solvers
from llsrbm.ocp.horizon import Iterate
from llsrbm.ocp.progress import when_idle
from llsrbm.planning.problem.knots import Knots
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.placement import check_turns, describe, make_task
from llsrbm.planning.problem.task import Task
from llsrbm.planning.problem.violations import describe_worst, excess, stops
from llsrbm.planning.solve.explanation import explained
from llsrbm.planning.solve.formulation import (
    CLOSE,
    PATIENT_FLIGHT,
    Array,
    Attempt,
    Formulation,
    solve_options,
    with_all_time,
)
from llsrbm.planning.solve.guess_table import Guesses
from llsrbm.planning.solve.progress import Progress, Watch
from llsrbm.planning.solve.search import FeasibilitySearch
from llsrbm.planning.solve.solver_cache import cached_solver
from llsrbm.request.jump import Jump
from llsrbm.request.jump_types import load_type, schedule_of
from llsrbm.robots import load_robot
from llsrbm.robots.robot import Robot

_log = logging.getLogger(__name__)

INTERVALS = 48
MIN_INTERVALS, MAX_INTERVALS = 9, 300  # 3 a phase; more than 300 take minutes to build

FOLLOWED = "from the last plan"
NEARBY = "from solutions nearby"
# Between solutions that violate no row by more than this 94 % of Go2's jumps (85 % of SLIDER's) are
# solved by following, in 4 iterations at the median; of the others every second one, in more.
NEARBY_MISS = 0.1
# The others: SLIDER's jumps take 13 iterations so, 16 with the first patience, and 18 from the
# analytic guess.
NEARER = replace(CLOSE, iterations=30)


class Planner:
    """Plans jumps of one robot with one model, of types with the same feet in the same phases.

    Attributes:
        formulation: what it solves, and with what.
        last: the last plan's attempt, for tests and studies; None when it failed.
    """

    def __init__(
        self,
        robot: Robot,
        model: str,
        solver: str = solvers.names()[0],
        layout: Layout | None = None,
    ) -> None:
        """Load the solver from the cache, or build and keep it.

        Args:
            robot, model: whose jumps, and what it believes of its inertia.
            solver: its name.
            layout: which feet stand in which phase; None: the jump type `together`.

        Raises:
            InputError: an unknown model or solver.
        """
        check_name(model)
        kind = solvers.by_name(solver)
        when_idle()
        made = make_model(model, robot)
        layout = layout or layout_of(Jump(robot=robot.name), robot)
        self.formulation = Formulation(
            robot, made, layout, cached_solver(kind, made, layout, robot)
        )
        self.last: Attempt | None = None

    @cached_property
    def guesses(self) -> Guesses:
        """The robot's table of solutions."""
        return Guesses(self.formulation)

    @property
    def robot(self) -> Robot:
        """The robot whose jumps are planned."""
        return self.formulation.robot

    @property
    def model(self) -> CentroidalModel:
        """Its centroidal model."""
        return self.formulation.model

    @property
    def layout(self) -> Layout:
        """Of the solver's variables."""
        return self.formulation.layout

    def plan(
        self,
        jump: Jump,
        *,
        weights: Mapping[str, float] | None = None,
        limits: Mapping[str, float] | None = None,
        near: Plan | None = None,
        guesses: bool = False,
        patient: bool = True,
        explains: bool = True,
        cancelled: Callable[[], bool] | None = None,
        progress: Progress | None = None,
    ) -> Plan:
        """Plan a jump.

        Args:
            jump: the request; robot and model are this planner's.
            weights: cost name -> weight, in place of the defaults.
            limits: limit name -> value, in place of the robot's (`llsrbm.planning.problem.limits`).
            near: a plan to start from, of another request to the same robot and model. A few
                degrees or centimetres away that is faster (docs/figures.md).
            guesses: begin from solutions nearby, if there is a table (`guess_table`). Without, the
                result depends on the request alone.
            patient: try all there is; otherwise only from `near`, from solutions nearby and from
                the analytic guess.
            explains: whether, with patience, the limits that stop a jump are looked for.
            cancelled: called before and during every solve; true to stop.
            progress: called with each attempt and the solver's iterations.

        Raises:
            InputError: the request is out of the robot's range, or `near` is of no use for it.
            NotConverged: no attempt satisfied every constraint; carries the nearest one. With
                patience and the default solver it names the limits that stop the jump, after some
                more seconds, unless it is not to; else what the nearest one violates.
            Cancelled: `cancelled` was true.
        """
        robot, layout = self.formulation.robot, self.formulation.layout
        task = make_task(jump, robot, weights, limits)
        if replace(layout_of(jump, robot), intervals=layout.intervals) != layout:
            raise InputError(
                f"this planner's feet stand as {layout.name}, those of the jump do not; expected "
                "a jump of the same type (planner_of finds its planner)"
            )
        watch = Watch(cancelled, progress)
        try:
            return self._planned(task, near, guesses, patient, watch)
        except NotConverged as error:
            can = patient and self.formulation.solver.name == solvers.names()[0]
            if not (explains and can) or jump.turns:  # flips beyond the drives: see `CAUTIOUS`
                raise
            raise explained(FeasibilitySearch(self.formulation, watch), error, task) from None

    def _planned(
        self, task: Task, near: Plan | None, guesses: bool, patient: bool, watch: Watch
    ) -> Plan:
        """The best attempt's plan."""
        start = time.perf_counter()
        watch.wait()
        tried: list[Attempt] = []
        for label, solve in self._attempts(task, near, guesses, patient, watch):
            watch.begin(f"attempt {len(tried) + 1}: {label}")
            tried.append(replace(self.formulation.agreed(solve(), watch), label=label))
            if tried[-1].solved:
                break
            _log.info("attempt %d, %s, failed", len(tried), label)
        best = min(tried, key=lambda attempt: (not attempt.solved, excess(attempt.violations)))
        self.last = best if best.solved else None

        seconds = sum(attempt.solution.solve_time_s for attempt in tried)
        plan = self.formulation.plan(best, len(tried), seconds, start)
        if not best.solved:
            raise NotConverged(
                f"no plan found in {len(tried)} attempts ({describe(task.jump)}); the nearest, "
                f"{best.label}: {describe_worst(best.violations, best.knots)}",
                plan,
                stops(best.knots),
            )
        return plan

    def _attempts(
        self, task: Task, near: Plan | None, guesses: bool, patient: bool, watch: Watch
    ) -> Iterator[tuple[str, Callable[[], Attempt]]]:
        """Label and solve of each attempt, in order; the next only when the one before failed."""
        guess = self.formulation.guess
        if near is not None:
            start = self._start(near)
            yield FOLLOWED, lambda: self.formulation.follow(task, start, watch)
        if guesses and (nearby := self.guesses.start(task)) is not None:
            yield NEARBY, lambda: self._from_nearby(nearby, task, watch)
        yield "from the analytic guess", lambda: self._solve(task, guess(task), watch)
        if task.jump.turns:
            # Part of how a flip is planned, also in a hurry.
            yield "by way of stronger drives", lambda: self._by_stronger_drives(task, watch)
        elif patient:
            yield (
                "from a longer flight",
                lambda: self._solve(task, guess(task, PATIENT_FLIGHT), watch),
            )
            yield "by way of easier jumps", lambda: self._by_easier_jumps(task, watch)

    def _by_stronger_drives(self, task: Task, watch: Watch) -> Attempt:
        """Solve with drives that give more first, then with less, each from the one before."""
        attempts: list[Attempt] = []
        start: Array | None = None
        for stronger in self.formulation.stronger(task):
            guess = self.formulation.guess(stronger) if start is None else start
            attempts.append(self._solve(stronger, guess, watch))
            if attempts[-1].solution.converged:
                start = attempts[-1].solution.variables
            elif start is not None:
                break
        return with_all_time(attempts)

    def _by_easier_jumps(self, task: Task, watch: Watch) -> Attempt:
        """Solve a share of the jump first, then larger ones, each from the one before."""
        attempts: list[Attempt] = []
        for easier in self.formulation.easier(task):
            if attempts:
                guess = self.formulation.moved(attempts[-1], easier)
            else:
                guess = self.formulation.guess(easier)
            attempts.append(self._solve(easier, guess, watch))
        return with_all_time(attempts)

    def _start(self, near: Plan) -> Iterate:
        """A plan's solution, from which the next one starts.

        Raises:
            UnusableStart: it is not this planner's.
        """
        knots, of = len(near.time), near.jump
        if (of.model, knots) != (self.model.name, self.layout.knots) or (
            near.robot_parameters != self.robot.parameters()
        ):
            raise UnusableStart(
                f"near: a plan of {of.robot} with {of.model} and {knots - 1} intervals cannot be "
                f"started from; expected {self.robot.name} as it is now with {self.model.name} "
                f"and {self.layout.knots - 1} intervals"
            )
        solution = near.solution
        if solution is None:
            raise UnusableStart(
                "near: a plan that did not converge, or whose file was written before files held "
                "what that takes, cannot be started from; expected one that converged"
            )
        sizes = len(solution.variables), len(solution.multipliers)
        expected = self.formulation.solver.sizes
        if sizes != expected:
            raise UnusableStart(
                f"near: the plan is of another version of the planner: {sizes[0]} variables and "
                f"{sizes[1]} constraints; expected {expected[0]} and {expected[1]}"
            )
        return solution

    def _from_nearby(self, start: Iterate, task: Task, watch: Watch) -> Attempt:
        """Follow from near; from further off, and where following creeps, solve from there."""
        attempts: list[Attempt] = []
        form = self.formulation
        if form.solver.miss(form.problem(task), start.variables) < NEARBY_MISS:
            attempts.append(form.follow(task, start, watch))
        if not attempts or not attempts[-1].solved:
            attempts.append(form.solve(task, start.variables, watch, NEARER))
        return with_all_time(attempts)

    def _solve(self, task: Task, guess: Array, watch: Watch) -> Attempt:
        return self.formulation.solve(task, guess, watch, solve_options(task))

    def last_knots(self) -> Knots:
        """The last solution in full, for tests and studies."""
        if self.last is None:
            raise InputError("this planner has no solution yet")
        return self.last.knots


def layout_of(jump: Jump, robot: Robot, intervals: int = INTERVALS) -> Layout:
    """The variables of a jump's plan; `intervals` as for three phases.

    Raises:
        InputError: a number of intervals that cannot be, or a jump type that is none.
    """
    if not MIN_INTERVALS <= intervals <= MAX_INTERVALS:
        raise InputError(
            f"intervals: {intervals} given; expected {MIN_INTERVALS} to {MAX_INTERVALS}"
        )
    contacts = len(robot.legs) * len(robot.corners)
    return Layout.of(
        schedule_of(jump, robot),
        contacts,
        intervals,
        robot.foot_coordinates,
        clears=load_type(jump.type).clears,
        turns=jump.turns,
    )


def planner_of(
    jump: Jump,
    solver: str = solvers.names()[0],
    intervals: int = INTERVALS,
    robot: Robot | None = None,
) -> Planner:
    """The planner of a jump's robot, model and type, built once a process.

    It is built again when the robot's file, or that of the type, has changed.

    Args:
        jump: a request.
        solver: its name.
        intervals: as for three phases.
        robot: the one that the request names, with other drives (`llsrbm.robots.drives`).

    Raises:
        InputError: a whole turn about an axis about which the robot makes none.
    """
    robot = robot or load_robot(jump.robot)
    if jump.turns:
        robot = robot.turning
        check_turns(jump, robot)
    return _kept(robot, jump.model, solver, layout_of(jump, robot, intervals))


def planner_for(
    robot: str, model: str, solver: str = solvers.names()[0], intervals: int = INTERVALS
) -> Planner:
    """The planner of a robot's name or file and a model's name, for jumps of the default type."""
    return planner_of(Jump(robot=robot, model=model), solver, intervals)


@lru_cache(maxsize=12)
def _kept(robot: Robot, model: str, solver: str, layout: Layout) -> Planner:
    return Planner(robot, model, solver, layout)
