"""A centroidal plan in, the whole body's plan out: solvers are built once and kept."""

from __future__ import annotations

import hashlib
import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

from llsrbm.arrays import Array
from llsrbm.motion.plan import Plan
from llsrbm.motion.robot import robot_of
from llsrbm.motion.solve_report import UNTRIED, Refinement
from llsrbm.ocp.horizon import Iterate, Solution
from llsrbm.ocp.progress import interruptible
from llsrbm.ocp.solvers import Fatrop, Solver
from llsrbm.planning.problem.placement import retargeted, task_of
from llsrbm.planning.problem.task import Task
from llsrbm.planning.solve.kept import kept
from llsrbm.planning.solve.solver_cache import Subject, cached_solver, is_compiling
from llsrbm.planning.solve.watch import Progress, Watch
from llsrbm.planning.whole_body.binding import Edge
from llsrbm.planning.whole_body.bounds import RowBounds
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.joined import joined
from llsrbm.planning.whole_body.learned_file import table_for
from llsrbm.planning.whole_body.motion import Motion
from llsrbm.planning.whole_body.problem import make_horizon
from llsrbm.planning.whole_body.requested_limits import limit_violations
from llsrbm.planning.whole_body.result import Feet, plan_of
from llsrbm.planning.whole_body.rounds import Rounds
from llsrbm.planning.whole_body.sizes import Sizes
from llsrbm.planning.whole_body.start import Start, footholds, start_of, tilts, without_offset
from llsrbm.planning.whole_body.unplanned import unplanned
from llsrbm.request.jump import Jump
from llsrbm.request.tuning import Tuning
from llsrbm.robots.robot import Robot

_log = logging.getLogger(__name__)

# Of slopes and stones, on the way to all of them: three of ANYmal's requests on slopes of up to 18
# degrees that are not found at once all are so, with three steps none is.
SHARES = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
_DIGITS = 8  # of what tells kinds of robots apart in names of files
SOLVED, FAILED = "solved", "not-converged"


class Moved(NamedTuple):
    """Where a landing is moved to.

    Attributes:
        solution: of that landing; offset: (4,) rad and m by which it is moved; edge: what stops it.
    """

    solution: Iterate
    offset: Array
    edge: Edge


class Refiner:
    """The whole-body problem of a robot's plans on one grid."""

    def __init__(self, robot: Robot, grid: Grid) -> None:
        """Load the solver from the cache, or build and keep it."""
        self.robot, self.grid = robot, grid
        self.solver = _solver(robot, grid)
        self.last: Motion | None = None  # of the last plan, for studies
        self.solution: Solution | None = None  # likewise
        self.rows: RowBounds | None = None  # of that solution

    def refine(
        self,
        plan: Plan,
        *,
        learned: bool = True,
        cancelled: Callable[[], bool] | None = None,
        progress: Progress | None = None,
    ) -> Plan:
        """The whole body's plan, begun from a centroidal one; that itself where there is none.

        Its `refinement` says which. A whole body's plan of another grid is begun from as it is.
        `learned`: begin from jumps nearby that were solved before, where there are some.

        Raises:
            Cancelled: `cancelled` was true.
        """
        called, watch = time.perf_counter(), Watch(cancelled, progress)
        watch.wait()
        watch.begin("refining: the whole body's dynamics")
        rounds = self._rounds(plan, watch)
        if plan.refined:
            rounds.near(start_of(plan, self.robot, self.grid).of_refined().straighter())
            return self._ended(rounds, plan, called)
        nearby = self.nearby(plan.jump, plan.tuning) if learned else None
        if nearby is not None:
            rounds.follow(self._beside(nearby, plan), nearby)
        if not rounds.solved:
            rounds.solve(start_of(plan, self.robot, self.grid).of_draft())
        if not rounds.solved:
            _log.info("the whole-body problem did not converge: %s", rounds.solutions[-1].message)
        return self._ended(rounds, plan, called)

    def keep(self, plan: Plan, task: Task, near: float, watch: Watch) -> Plan:
        """The whole body's plan nearest to a motion, of which nothing need hold.

        Where it is not found it is that motion; its `refinement` says which, its `violations` what
        the rows of the problem miss.

        Args:
            plan: the motion, on any grid.
            task: of its own footholds, which its request need not know.
            near: weight of nearness to it.
            watch: of progress and cancellation.

        Raises:
            Cancelled: it is not wanted any more.
        """
        called = time.perf_counter()
        watch.wait()
        watch.begin("the whole body's dynamics, near to the motion")
        rounds = self._rounds(plan, watch)
        start = start_of(plan, self.robot, self.grid, task).kept(near)
        if plan.refined:
            rounds.near(start.straighter())
        else:
            rounds.solve(start)
        return replace(self._ended(rounds, plan, called), violations=rounds.found)

    def learned(self, task: Task, watch: Watch) -> Plan | None:
        """The whole body's plan, begun from jumps nearby that were solved before, without a draft.

        None: there are none, or it is not found from there.

        Raises:
            Cancelled: `cancelled` was true.
        """
        nearby = self.nearby(task.jump, task.tuning)
        if nearby is None:
            return None
        uneven = task.jump != task.jump.on_ground(0.0)
        found = self.beside(task, nearby, watch, alone=uneven)
        if uneven and not found.refined:
            found = self._gradually(task, nearby, watch)
        return found if found.refined else None

    def _gradually(self, task: Task, nearby: Iterate, watch: Watch) -> Plan:
        """From the same jump on level ground to slopes and stones, a share of them at a time."""
        for share in SHARES:
            jump = task.jump.on_ground(share)
            found = self.beside(task if share == 1.0 else retargeted(task, jump), nearby, watch)
            if not found.refined:
                break
            assert self.solution is not None
            nearby = self.solution
        return found

    def beside(
        self,
        task: Task,
        nearby: Iterate,
        watch: Watch,
        *,
        alone: bool = False,
        straighter: bool = False,
    ) -> Plan:
        """The whole body's plan, begun from the solution of a jump nearby, without a draft.

        `alone`, `straighter`: see `Rounds.follow`.

        Where it is not found (`Plan.refined`) it has no knots.

        Raises:
            Cancelled: `cancelled` was true.
        """
        called = time.perf_counter()
        plan = unplanned(task, self.robot, self.solver.name)
        watch.begin("the whole body's dynamics, from jumps nearby")
        rounds = self._rounds(plan, watch)
        begun = self._beside(nearby, plan)
        rounds.follow(begun, nearby, alone=alone, straighter=straighter)
        return self._ended(rounds, plan, called)

    def moved(
        self, task: Task, nearby: Iterate, wanted: Array, price: float, watch: Watch
    ) -> Moved | None:
        """A landing that is moved towards one that is wanted, from a solution nearby.

        None: it leads nowhere.

        Args:
            task: of the landing as it is.
            nearby: a solution of that, or nearly.
            wanted: by how much it is wanted to be moved; price: see `Start`.
            watch: of progress and cancellation.

        Raises:
            Cancelled: it is not wanted any more.
        """
        plan = unplanned(task, self.robot, self.solver.name)
        watch.begin("the whole body's dynamics, towards the request")
        rounds = self._rounds(plan, watch)
        start = replace(self._beside(nearby, plan).straighter(), wanted=wanted, price=price)
        if not rounds.reach(start, nearby):
            return None
        solution, sizes = rounds.solutions[-1], rounds.sizes
        assert rounds.start is not None
        offset = Motion.of(solution.variables, self.grid, sizes).state["offset"][0] * (wanted != 0)
        variables = without_offset(solution.variables, self.grid, sizes)
        edge = Edge(RowBounds(self.robot, self.grid, sizes, rounds.start), solution, nearby)
        return Moved(Iterate(variables, solution.multipliers), offset, edge)

    def _rounds(self, plan: Plan, watch: Watch) -> Rounds:
        return Rounds(self.robot, self.grid, self.solver, plan.schedule.names, watch)

    def nearby(self, jump: Jump, tuning: Tuning) -> Iterate | None:
        """Where a jump begins by the robot's table of solved jumps; None: no table is of it."""
        table = table_for(jump, tuning, self.grid)
        return None if table is None or table.sizes != self.solver.sizes else table.guess(jump)

    def _ended(self, rounds: Rounds, plan: Plan, called: float) -> Plan:
        """The whole body's plan, or the one that it was begun from, with a report on both."""
        result, last = plan, rounds.solutions[-1]
        if rounds.solved:
            assert rounds.motion is not None
            assert rounds.start is not None
            self.last, self.solution = rounds.motion, rounds.solution
            self.rows = RowBounds(self.robot, self.grid, rounds.sizes, rounds.start)
            feet = Feet(rounds.start.place, rounds.start.foot_quat, rounds.start.tilt)
            whole = plan_of(rounds.motion, feet, plan, self.robot, self.grid)
            beyond = limit_violations(whole, rounds.start.task, self.robot)
            result = replace(whole, violations=rounds.found | beyond, certificate=None)
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

    def _beside(self, nearby: Iterate, plan: Plan) -> Start:
        """A start whose motion is that of variables nearby; of the plan only its request counts."""
        robot, grid = self.robot, self.grid
        motion = Motion.of(nearby.variables, grid, Sizes.of(robot, len(grid.phases)))
        task = task_of(plan, robot)
        feet = Feet(*footholds(task, grid), tilts(task, grid))
        return start_of(plan_of(motion, feet, plan, robot, grid), robot, grid).ended(robot)


def refined(
    plan: Plan,
    robot: Robot | None = None,
    *,
    learned: bool = True,
    finer: float = 1.0,
    cancelled: Callable[[], bool] | None = None,
    progress: Progress | None = None,
) -> Plan:
    """`Refiner.refine` of a plan that converged, by a solver that is built once a process.

    It is not tried where the body turns over and lands on all feet at once.

    `robot`: the one that the plan names, with other drives. `finer`: times as many intervals.
    """
    if untried(plan):
        # None of Go2's was ever found: drafts' knees land at twice the speed that they have.
        return replace(plan, refinement=Refinement(UNTRIED, 0, 0.0, 0.0, 0.0, 0.0, compiling=False))
    start = time.perf_counter()
    refiner = interruptible(partial(refiner_of, plan, robot, finer), cancelled)
    built = time.perf_counter() - start
    result = refiner.refine(plan, learned=learned, cancelled=cancelled, progress=progress)
    assert result.refinement is not None
    return replace(result, refinement=replace(result.refinement, build_time_s=built))


def untried(plan: Plan) -> bool:
    """Whether a plan stays a draft: a body that turns over and lands on all feet at once."""
    return bool(plan.jump.turns) and not plan.schedule.is_caught


def planned(
    task: Task,
    counts: Sequence[int],
    *,
    settles: bool = False,
    cancelled: Callable[[], bool] | None = None,
    progress: Progress | None = None,
) -> Plan | None:
    """`Refiner.learned` of a task, by a solver that is built once a process.

    No solver is built for robots without a table. `counts`: the intervals of each phase of a draft;
    `settles`: wait until the solver is compiled.
    """
    grid, watch = Grid.at(task.schedule, counts), Watch(cancelled, progress)
    if table_for(task.jump, task.tuning, grid) is None:
        return None
    start = time.perf_counter()
    refiner = refiner_at(task.robot, grid, watch, settles=settles)
    built = time.perf_counter() - start
    found = refiner.learned(task, watch)
    if found is None:
        return None
    assert found.refinement is not None
    return replace(found, refinement=replace(found.refinement, build_time_s=built))


def planned_through(
    task: Task,
    counts: Sequence[int],
    parts: Sequence[Plan],
    *,
    settles: bool = False,
    cancelled: Callable[[], bool] | None = None,
    progress: Progress | None = None,
) -> Plan | None:
    """The whole body's plan of jumps in a row, begun from plans of each; None: it is not found.

    The rest as `planned`.
    """
    watch = Watch(cancelled, progress)
    start = time.perf_counter()
    refiner = refiner_at(task.robot, Grid.at(task.schedule, counts), watch, settles=settles)
    built = time.perf_counter() - start
    begun = joined(task, unplanned(task, task.robot, refiner.solver.name), parts)
    found = refiner.refine(begun, cancelled=cancelled, progress=progress)
    assert found.refinement is not None
    if found.refinement.status != SOLVED:
        return None
    return replace(found, refinement=replace(found.refinement, build_time_s=built))


def refiner_at(robot: Robot, grid: Grid, watch: Watch, *, settles: bool = False) -> Refiner:
    """The whole-body problem on a grid, built once and kept; `settles`: its solver is compiled.

    Raises `Cancelled`: it is not wanted any more.
    """
    watch.wait()
    refiner = watch.built(partial(Refiner, robot, grid))
    if settles:
        refiner.solver.settle()
    return refiner


def refiner_of(plan: Plan, robot: Robot | None = None, finer: float = 1.0) -> Refiner:
    """The whole-body problem of plans like this one, built once and kept; the rest as `refined`."""
    return Refiner(robot or robot_of(plan), Grid.of(plan, finer))


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
