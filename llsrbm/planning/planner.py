"""Request in, plan out: one warm solver for each robot, model, solver and number of intervals."""

from __future__ import annotations

import logging
import time
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from llsrbm.cache import cached_bytes, content_key
from llsrbm.errors import Cancelled, InputError, NotConverged
from llsrbm.jump import Jump
from llsrbm.models import check_name, make_model
from llsrbm.planning import solvers
from llsrbm.planning.assembly import assemble_plan
from llsrbm.planning.guess import analytic_guess
from llsrbm.planning.knots import Knots, rolled_out, unpack
from llsrbm.planning.layout import Intervals, Layout
from llsrbm.planning.residuals import describe_worst, excess, satisfied, violations
from llsrbm.planning.solvers import Backend, Iterate
from llsrbm.planning.task import Task, make_task, place_task
from llsrbm.planning.transcription import Problem, row_bounds
from llsrbm.robots import load_robot
from llsrbm.robots.robot import Robot
from llsrbm.trajectory.plan import Plan, SolveReport, Violation

Array = NDArray[np.float64]
Progress = Callable[[str], None]

_log = logging.getLogger(__name__)

INTERVALS = 48
MIN_INTERVALS, MAX_INTERVALS = 9, 300  # 3 a phase; more than 300 take minutes to build

# Flight time of the second attempt's guess, s: long flights leave room for what a short one cannot.
PATIENT_FLIGHT = 0.45
# Shares of the request that the third attempt solves one after another.
HOMOTOPY = (0.34, 0.67, 1.0)


@dataclass(frozen=True, eq=False)
class _Attempt:
    label: str
    iterate: Iterate
    knots: Knots
    violations: dict[str, Violation]

    @property
    def solved(self) -> bool:
        return self.iterate.converged and satisfied(self.violations)


class Planner:
    """Plans jumps of one robot with one model; remembers its last solution for warm starts."""

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
        warm: bool = False,
        cancelled: Callable[[], bool] | None = None,
        progress: Progress | None = None,
    ) -> Plan:
        """Plan a jump.

        Args:
            jump: the request; robot and model are this planner's.
            weights: cost name -> weight, in place of the defaults.
            limits: limit name -> value, in place of the robot's (`llsrbm.planning.limits`).
            warm: start from this planner's last solution.
            cancelled: asked before every solve.
            progress: told what is being tried.

        Raises:
            InputError: the request is out of the robot's range.
            NotConverged: no attempt satisfied every constraint; carries the nearest one.
            Cancelled: `cancelled` said so.
        """
        start = time.perf_counter()
        task = make_task(jump, self.robot, weights, limits)

        def check() -> None:
            if cancelled is not None and cancelled():
                raise Cancelled("planning was cancelled")

        solve_time = 0.0
        tried: list[_Attempt] = []
        for label, solve in self._attempts(task, warm, check):
            check()
            if progress is not None:
                progress(f"attempt {len(tried) + 1}: {label}")
            iterate = solve()
            solve_time += iterate.solve_time_s
            knots = rolled_out(unpack(iterate.w, self.layout, task, self.model))
            tried.append(_Attempt(label, iterate, knots, violations(knots)))
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
                solve_time_s=solve_time,
                total_time_s=time.perf_counter() - start,
                build_time_s=0.0,
                cost=best.iterate.cost,
            )

        plan = assemble_plan(jump, self.robot, best.knots, best.violations, report)
        if not best.solved:
            raise NotConverged(
                f"no plan found in {len(tried)} attempts ({_describe(jump)}); the nearest, "
                f"{best.label}: {describe_worst(best.violations)}",
                plan,
            )
        return plan

    def _attempts(
        self, task: Task, warm: bool, check: Callable[[], None]
    ) -> Iterator[tuple[str, Callable[[], Iterate]]]:
        """What is tried, in order, each only when the one before failed."""
        if warm and self.last is not None:
            last = self.last
            yield "from the last plan", lambda: self._from(*last, task)
        yield "from the analytic guess", lambda: self._solve(task, self._guess(task))
        yield (
            "from a longer flight",
            lambda: self._solve(task, self._guess(task, PATIENT_FLIGHT)),
        )
        yield "by way of easier jumps", lambda: self._by_easier_jumps(task, check)

    def _by_easier_jumps(self, task: Task, check: Callable[[], None]) -> Iterate:
        """Solve a share of the jump first, then larger ones, each from the one before."""
        easier = place_task(_scaled(task.jump, HOMOTOPY[0]), self.robot, task.tuning)
        iterate = self._solve(easier, self._guess(easier))
        solve_time = iterate.solve_time_s
        for share in HOMOTOPY[1:]:
            check()
            harder = place_task(_scaled(task.jump, share), self.robot, task.tuning)
            iterate = self._from(easier, iterate, harder)
            easier = harder
            solve_time += iterate.solve_time_s
        return replace(iterate, solve_time_s=solve_time)

    def _from(self, old: Task, solution: Iterate, task: Task) -> Iterate:
        """Solve from another task's solution, moved as the analytic guesses of the two differ."""
        w = solution.w + self._guess(task) - self._guess(old)
        for knot in range(self.layout.knots):
            place = self.layout.variables(knot).get("quat")
            if place is not None:
                w[place] /= np.linalg.norm(w[place])
        return self._solve(task, w, warm=True)

    def _guess(self, task: Task, flight_time: float | None = None) -> Array:
        return analytic_guess(task, self.layout, self.model, flight_time)

    def _solve(self, task: Task, guess: Array, warm: bool = False) -> Iterate:
        parameters = np.concatenate(list(task.parameters().values()))
        return self._backend.solve(guess, parameters, row_bounds(self.layout, task), warm)

    def last_knots(self) -> Knots:
        """The last solution in full, for tests and studies."""
        if self.last is None:
            raise InputError("this planner has no solution yet")
        task, iterate = self.last
        return rolled_out(unpack(iterate.w, self.layout, task, self.model))


def _scaled(jump: Jump, share: float) -> Jump:
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
        for package in ("models", "planning")
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
    """The planner of a robot's name or file and a model's name, built once a process."""
    return _kept(robot, model, solver, intervals)


# Apart from `planner_for`: the cache tells a default that is given from one that is left out.
@lru_cache(maxsize=12)
def _kept(robot: str, model: str, solver: str, intervals: int) -> Planner:
    return Planner(load_robot(robot), model, solver, intervals)
