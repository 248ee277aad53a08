"""A centroidal plan in, the whole body's plan out: solvers are built once and kept."""

from __future__ import annotations

import hashlib
import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from llsrbm.motion.plan import Plan, Refinement
from llsrbm.motion.robot import robot_of
from llsrbm.ocp.horizon import Iterate, Solution
from llsrbm.ocp.progress import interruptible
from llsrbm.ocp.solvers import Fatrop, Solver
from llsrbm.planning.solve.kept import kept
from llsrbm.planning.solve.solver_cache import Subject, cached_solver, is_compiling
from llsrbm.planning.solve.watch import Progress, Watch
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.learned import begun
from llsrbm.planning.whole_body.motion import Motion
from llsrbm.planning.whole_body.problem import make_horizon
from llsrbm.planning.whole_body.result import plan_of
from llsrbm.planning.whole_body.rounds import Rounds
from llsrbm.planning.whole_body.sizes import Sizes
from llsrbm.planning.whole_body.start import Start, start_of
from llsrbm.robots.robot import Robot

_log = logging.getLogger(__name__)

_DIGITS = 8  # of what tells kinds of robots apart in names of files
SOLVED, FAILED, UNTRIED = "solved", "not-converged", "not-tried"


class Refiner:
    """The whole-body problem of a robot's plans on one grid."""

    def __init__(self, robot: Robot, grid: Grid) -> None:
        """Load the solver from the cache, or build and keep it."""
        self.robot, self.grid = robot, grid
        self.solver = _solver(robot, grid)
        self.last: Motion | None = None  # of the last plan, for studies
        self.solution: Solution | None = None  # likewise

    def refine(
        self,
        plan: Plan,
        *,
        learned: bool = True,
        cancelled: Callable[[], bool] | None = None,
        progress: Progress | None = None,
    ) -> Plan:
        """The whole body's plan, begun from a centroidal one; that itself where there is none.

        Its `refinement` says which. `learned`: begin from jumps nearby that were solved before,
        where there are some.

        Raises:
            Cancelled: `cancelled` was true.
        """
        called, watch = time.perf_counter(), Watch(cancelled, progress)
        watch.wait()
        watch.begin("refining: the whole body's dynamics")
        rounds = Rounds(self.robot, self.grid, self.solver, plan.schedule.names, watch)
        first = start_of(plan, self.robot, self.grid)
        nearby = begun(plan, self.robot, self.grid, self.solver.sizes) if learned else None
        if nearby is not None:
            rounds.follow(self._beside(nearby, plan, first), nearby)
        if not rounds.solved:
            rounds.solve(first)
        result, last = plan, rounds.solutions[-1]
        if rounds.solved:
            assert rounds.motion is not None
            assert rounds.start is not None
            self.last, self.solution = rounds.motion, rounds.solution
            whole = plan_of(rounds.motion, rounds.start, plan, self.robot, self.grid)
            result = replace(whole, violations=rounds.found)
        else:
            _log.info("the whole-body problem did not converge: %s", last.message)
        report = Refinement(
            status=SOLVED if rounds.solved else FAILED,
            iterations=sum(each.iterations for each in rounds.solutions),
            solve_time_s=sum(each.solve_time_s for each in rounds.solutions),
            total_time_s=time.perf_counter() - called,
            build_time_s=0.0,
            cost=last.cost,
            compiling=is_compiling(self.solver),
        )
        return replace(result, refinement=report)

    def _beside(self, nearby: Iterate, plan: Plan, first: Start) -> Start:
        """A start whose motion is that of variables nearby; `first`: the draft's."""
        sizes = Sizes.of(self.robot, len(self.grid.phases))
        motion = Motion.of(nearby.variables, self.grid, sizes)
        there = first.timed(motion.durations, self.grid)
        return start_of(plan_of(motion, there, plan, self.robot, self.grid), self.robot, self.grid)


def refined(
    plan: Plan,
    robot: Robot | None = None,
    *,
    learned: bool = True,
    cancelled: Callable[[], bool] | None = None,
    progress: Progress | None = None,
) -> Plan:
    """`Refiner.refine` of a plan that converged, by a solver that is built once a process.

    It is not tried where the body turns over.

    `robot`: the one that the plan names, with other drives.
    """
    if plan.jump.turns:
        # None of Go2's was ever found: drafts' knees land at twice the speed that they have.
        return replace(plan, refinement=Refinement(UNTRIED, 0, 0.0, 0.0, 0.0, 0.0, compiling=False))
    start = time.perf_counter()
    refiner = interruptible(partial(refiner_of, plan, robot), cancelled)
    built = time.perf_counter() - start
    result = refiner.refine(plan, learned=learned, cancelled=cancelled, progress=progress)
    assert result.refinement is not None
    return replace(result, refinement=replace(result.refinement, build_time_s=built))


def refiner_of(plan: Plan, robot: Robot | None = None) -> Refiner:
    """The whole-body problem of plans like this one, built once and kept; `robot`: of `refined`."""
    return Refiner(robot or robot_of(plan), Grid.of(plan))


def _subject(robot: Robot, sizes: Sizes, grid: Grid) -> Subject:
    """The problem of all robots of these sizes."""
    numbers = repr((replace(sizes, weight=0.0), grid))
    kind = hashlib.sha256(repr(replace(sizes, weight=0.0)).encode()).hexdigest()[:_DIGITS]
    return Subject(
        of=f"whole-body-{sizes.legs}-legs-{sizes.joints}-joints-{kind}",
        variant=grid.name,
        title=f"whole-body solver of robots that are built like {robot.name}",
        numbers=numbers,
        horizon=lambda: make_horizon(sizes, grid),
    )


@dataclass(frozen=True)
class _Solves:
    """A solver, for all robots of the same sizes."""

    solvers: tuple[Solver]


def _solver(robot: Robot, grid: Grid) -> Solver:
    sizes = Sizes.of(robot, len(grid.phases))

    def make() -> _Solves:
        return _Solves((cached_solver(Fatrop, _subject(robot, sizes, grid)),))

    return kept((_Solves, sizes, grid), make).solvers[0]
