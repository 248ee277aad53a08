"""Request in, plan out: one warm solver for each robot, model, solver and number of intervals."""

from __future__ import annotations

import logging
import time
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from llsrbm.cache import cached_bytes, content_key
from llsrbm.errors import Cancelled, InputError, NotConverged
from llsrbm.jump import Jump
from llsrbm.models import check_name, make_model
from llsrbm.motion.plan import Plan, Solution, SolveReport, Violation
from llsrbm.ocp import solvers
from llsrbm.ocp.progress import IterationTable, PlanningProgress, attended
from llsrbm.ocp.solvers import Backend, Iterate
from llsrbm.ocp.transcription import Problem, row_bounds
from llsrbm.planning.assembly import assemble_plan
from llsrbm.planning.guess import analytic_guess
from llsrbm.planning.knots import Knots, rolled_out, unpack
from llsrbm.planning.layout import Intervals, Layout
from llsrbm.planning.residuals import describe_worst, excess, satisfied, stops, violations
from llsrbm.planning.task import Task, make_task, place_task
from llsrbm.robots import load_robot
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]
Progress = Callable[[PlanningProgress], None]

_log = logging.getLogger(__name__)

INTERVALS = 48
MIN_INTERVALS, MAX_INTERVALS = 9, 300  # 3 a phase; more than 300 take minutes to build

# Flight time of the second attempt's guess, s: long flights leave room for what a short one cannot.
PATIENT_FLIGHT = 0.45
# Shares of the request that the last attempt solves one after another.
HOMOTOPY = (0.34, 0.67, 1.0)
# Solves from the last plan before it is given up: the second one mends what the first let slip, a
# far bound that was passed or rows that Fatrop saw scaled.
FOLLOWS = 2
FOLLOWED = "from the last plan"


@dataclass(frozen=True, eq=False)
class _Attempt:
    iterate: Iterate
    knots: Knots
    violations: dict[str, Violation]
    label: str = ""

    @property
    def solved(self) -> bool:
        return self.iterate.converged and satisfied(self.violations)


class Planner:
    """Plans jumps of one robot with one model.

    Attributes:
        robot, model, layout: what it plans with.
        last: task and iterate of the last plan, for tests and studies; None when it failed.
    """

    def __init__(
        self,
        robot: Robot,
        model: str,
        solver: str = solvers.names()[0],
        intervals: int = INTERVALS,
    ) -> None:
        """Load the solver from the cache, or build and keep it.

        Raises:
            InputError: an unknown model or solver, or a number of intervals that cannot be.
        """
        check_name(model)
        kind = solvers.backend(solver)
        if not MIN_INTERVALS <= intervals <= MAX_INTERVALS:
            raise InputError(
                f"intervals: {intervals} given; expected {MIN_INTERVALS} to {MAX_INTERVALS}"
            )
        self.robot = robot
        self.model = make_model(model, robot)
        self.layout = Layout(
            legs=len(robot.legs),
            contacts=len(robot.legs) * len(robot.corners),
            intervals=Intervals.split(intervals),
            foot_coordinates=robot.foot_coordinates,
        )
        self._backend = _cached_backend(kind, self.model, self.layout, robot)
        self.last: tuple[Task, Iterate] | None = None

    def plan(
        self,
        jump: Jump,
        *,
        weights: Mapping[str, float] | None = None,
        limits: Mapping[str, float] | None = None,
        near: Plan | None = None,
        patient: bool = True,
        cancelled: Callable[[], bool] | None = None,
        progress: Progress | None = None,
    ) -> Plan:
        """Plan a jump.

        Args:
            jump: the request; robot and model are this planner's.
            weights: cost name -> weight, in place of the defaults.
            limits: limit name -> value, in place of the robot's (`llsrbm.planning.limits`).
            near: a plan to start from, of another request to the same robot and model: a few
                degrees or centimetres away it takes a fifth of the time.
            patient: try all there is; otherwise only from `near` and from the analytic guess.
            cancelled: asked before and during every solve.
            progress: told what is being tried, and how it goes.

        Raises:
            InputError: the request is out of the robot's range, or `near` is of no use for it.
            NotConverged: no attempt satisfied every constraint; carries the nearest one.
            Cancelled: `cancelled` said so.
        """
        start = time.perf_counter()
        task = make_task(jump, self.robot, weights, limits)
        watch = _Watch(cancelled, progress)
        tried: list[_Attempt] = []
        for label, solve in self._attempts(task, near, patient, watch):
            watch.begin(f"attempt {len(tried) + 1}: {label}")
            tried.append(replace(solve(), label=label))
            if tried[-1].solved:
                break
            _log.info("attempt %d, %s, failed", len(tried), label)
        best = min(tried, key=lambda attempt: (not attempt.solved, excess(attempt.violations)))
        self.last = (task, best.iterate) if best.solved else None

        def report() -> SolveReport:
            return SolveReport(
                status="solved" if best.solved else "not-converged",
                solver=self._backend.name,
                iterations=best.iterate.iterations,
                attempts=len(tried),
                solve_time_s=sum(attempt.iterate.solve_time_s for attempt in tried),
                total_time_s=time.perf_counter() - start,
                build_time_s=0.0,
                cost=best.iterate.cost,
            )

        solution = best.iterate.solution if best.solved else None
        plan = assemble_plan(jump, self.robot, best.knots, best.violations, report, solution)
        if not best.solved:
            raise NotConverged(
                f"no plan found in {len(tried)} attempts ({_describe(jump)}); the nearest, "
                f"{best.label}: {describe_worst(best.violations, best.knots)}",
                plan,
                stops(best.knots),
            )
        return plan

    def _attempts(
        self, task: Task, near: Plan | None, patient: bool, watch: _Watch
    ) -> Iterator[tuple[str, Callable[[], _Attempt]]]:
        """What is tried, in order, each only when the one before failed."""
        if near is not None:
            solution = self._solution(near)
            yield FOLLOWED, lambda: self._follow(solution, task, watch)
        yield "from the analytic guess", lambda: self._solve(task, self._guess(task), watch)
        if patient:
            yield (
                "from a longer flight",
                lambda: self._solve(task, self._guess(task, PATIENT_FLIGHT), watch),
            )
            yield "by way of easier jumps", lambda: self._by_easier_jumps(task, watch)

    def _by_easier_jumps(self, task: Task, watch: _Watch) -> _Attempt:
        """Solve a share of the jump first, then larger ones, each from the one before."""
        attempts: list[_Attempt] = []
        guess = np.zeros(0)
        for share in HOMOTOPY:
            harder = place_task(scaled(task.jump, share), self.robot, task.tuning)
            easier_guess, guess = guess, self._guess(harder)
            if not attempts:
                start = guess
            else:  # the last solution, moved as the analytic guesses of the two differ
                start = self._normalised(attempts[-1].iterate.w + guess - easier_guess)
            attempts.append(self._solve(harder, start, watch))
        return _with_all_time(attempts)

    def _normalised(self, w: Array) -> Array:
        for knot in range(self.layout.knots):
            place = self.layout.variables(knot).get("quat")
            if place is not None:
                w[place] /= np.linalg.norm(w[place])
        return w

    def _solution(self, near: Plan) -> Solution:
        """What a plan holds for the next one.

        Raises:
            InputError: it is not this planner's.
        """
        knots, of = len(near.time), near.jump
        if (of.model, knots) != (self.model.name, self.layout.knots) or (
            near.robot_parameters != self.robot.parameters()
        ):
            raise InputError(
                f"near: a plan of {of.robot} with {of.model} and {knots - 1} intervals cannot be "
                f"started from; expected {self.robot.name} as it is now with {self.model.name} "
                f"and {self.layout.knots - 1} intervals"
            )
        solution = near.solution
        if solution is None:
            raise InputError(
                "near: a plan that did not converge, or whose file was written before files held "
                "what that takes, cannot be started from; expected one that converged"
            )
        sizes = len(solution.variables), len(solution.multipliers)
        expected = self._backend.sizes
        if sizes != expected:
            raise InputError(
                f"near: the plan is of another version of the planner: {sizes[0]} variables and "
                f"{sizes[1]} constraints; expected {expected[0]} and {expected[1]}"
            )
        return solution

    def _follow(self, solution: Solution, task: Task, watch: _Watch) -> _Attempt:
        parameters, bounds = self._numbers(task)
        attempts: list[_Attempt] = []
        for _ in range(FOLLOWS):
            follow = partial(self._backend.follow, solution, parameters, bounds)
            attempts.append(self._judged(task, watch.over(follow)))
            if attempts[-1].solved or not attempts[-1].iterate.converged:
                break
            solution = attempts[-1].iterate.solution
        return _with_all_time(attempts)

    def _solve(self, task: Task, guess: Array, watch: _Watch) -> _Attempt:
        parameters, bounds = self._numbers(task)
        solve = partial(self._backend.solve, guess, parameters, bounds, watch.read)
        return self._judged(task, watch.over(solve))

    def _numbers(self, task: Task) -> tuple[Array, tuple[Array, Array]]:
        """Parameters of the solver, and bounds of its rows."""
        return np.concatenate(list(task.parameters().values())), row_bounds(self.layout, task)

    def _judged(self, task: Task, iterate: Iterate) -> _Attempt:
        knots = rolled_out(unpack(iterate.w, self.layout, task, self.model))
        return _Attempt(iterate, knots, violations(knots))

    def _guess(self, task: Task, flight_time: float | None = None) -> Array:
        return analytic_guess(task, self.layout, self.model, flight_time)

    def last_knots(self) -> Knots:
        """The last solution in full, for tests and studies."""
        if self.last is None:
            raise InputError("this planner has no solution yet")
        task, iterate = self.last
        return rolled_out(unpack(iterate.w, self.layout, task, self.model))


class _Watch:
    """Whether to go on, and whom to tell how it goes."""

    def __init__(self, cancelled: Callable[[], bool] | None, progress: Progress | None) -> None:
        self._cancelled, self._progress = cancelled, progress
        self._text = ""
        self._table = IterationTable()

    @property
    def read(self) -> Callable[[str], None] | None:
        """Takes what a solver prints; None when nobody wants to know."""
        return None if self._progress is None else self._table.read

    def begin(self, text: str) -> None:
        """Tell what comes next.

        Raises:
            Cancelled: it is not wanted any more.
        """
        if self._cancelled is not None and self._cancelled():
            raise Cancelled("planning was cancelled")
        self._text = text
        # A new one before anybody takes hold of its `read`.
        self._table = IterationTable()
        if self._progress is not None:
            self._progress(PlanningProgress(text))

    def over(self, solve: Callable[[], Iterate]) -> Iterate:
        """What `solve` returns, watched over.

        Raises:
            Cancelled: it is not wanted any more.
        """
        tell = None if self._progress is None else self._tell
        return attended(solve, lambda: self._table.last, tell, self._cancelled)

    def _tell(self, iteration: int, residual: float) -> None:
        if self._progress is not None:
            self._progress(PlanningProgress(self._text, iteration, residual))


def _with_all_time(attempts: list[_Attempt]) -> _Attempt:
    """The last attempt, with the time that all of them took."""
    seconds = sum(attempt.iterate.solve_time_s for attempt in attempts)
    return replace(attempts[-1], iterate=replace(attempts[-1].iterate, solve_time_s=seconds))


def scaled(jump: Jump, share: float) -> Jump:
    """A share of what is asked."""
    motion = {k: share * getattr(jump, k) for k in ("twist", "forward", "lateral", "height")}
    return Jump(robot=jump.robot, model=jump.model, **motion)


def _describe(jump: Jump) -> str:
    return (
        f"twist {np.degrees(jump.twist):g} deg, forward {jump.forward:g} m, "
        f"lateral {jump.lateral:g} m, height {jump.height:g} m, {jump.model}"
    )


def _cached_backend(kind: type[Backend], model: Any, layout: Layout, robot: Robot) -> Backend:
    def build() -> bytes:
        _log.info("building the %s solver of %s, once on this machine", model.name, robot.name)
        text = kind.build(Problem(model, layout)).serialize()
        return zlib.compress(text.encode("ascii"), level=1)

    sources = sorted(
        path
        for package in ("models", "ocp", "planning")
        for path in (Path(__file__).parents[1] / package).rglob("*.py")
    )
    key = content_key(
        ca.__version__,
        f"{kind.name} {model.name} {layout}",
        repr(robot.parameters()),
        repr(model.numbers()),
        *sources,
    )
    name = f"solver-{robot.name}-{model.name}-{kind.name}"
    stored = cached_bytes(name, key, ".casadi.z", build)
    return kind.deserialize(zlib.decompress(stored).decode("ascii"))


def planner_for(
    robot: str, model: str, solver: str = solvers.names()[0], intervals: int = INTERVALS
) -> Planner:
    """The planner of a robot's name or file and a model's name, built once a process.

    It is built again when the robot's file has changed.
    """
    return _kept(load_robot(robot), model, solver, intervals)


# Apart from `planner_for`: the cache tells a default that is given from one that is left out.
@lru_cache(maxsize=12)
def _kept(robot: Robot, model: str, solver: str, intervals: int) -> Planner:
    return Planner(robot, model, solver, intervals)
