"""Request in, plan out: one warm solver for each robot, model, solver and number of intervals."""

from __future__ import annotations

import logging
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial

from llsrbm.arrays import Array
from llsrbm.errors import InputError
from llsrbm.models import make_model
from llsrbm.models.base import CentroidalModel
from llsrbm.motion.plan import Plan
from llsrbm.motion.solve_report import NEAREST
from llsrbm.ocp import solvers
from llsrbm.ocp.horizon import Iterate
from llsrbm.ocp.progress import interruptible, when_idle
from llsrbm.planning.answer.first_feasible import first_feasible, with_bounds_nearby
from llsrbm.planning.answer.nearby import from_nearby, usable_start
from llsrbm.planning.answer.nearest import Nearest, find_nearest
from llsrbm.planning.answer.reasons import refusal, unexplained
from llsrbm.planning.problem.knots import Knots
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.placement import check_turns, make_task
from llsrbm.planning.problem.task import Task
from llsrbm.planning.solve.formulation import Attempt, Formulation, best_of, solve_options
from llsrbm.planning.solve.jump_layout import INTERVALS, layout_of
from llsrbm.planning.solve.kept import kept
from llsrbm.planning.solve.solver_cache import cached_solver, is_built, of_jumps
from llsrbm.planning.solve.watch import Progress, Watch
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.robots import load_robot
from llsrbm.robots.drives.variants import with_strength
from llsrbm.robots.robot import Robot

_log = logging.getLogger(__name__)

FOLLOWED = "from the last plan"
BY_NEARER = "by way of nearer jumps"
NOT_TRIED = "as the nearest jump"  # the motion of that one, where the request itself was not tried
KEPT = 3  # plans' attempts: a slider's step begins from the plan shown, which need not be the last
# From a guess, where the nearest jump is looked for next: of ANYmal's uniform requests nine in ten
# are planned by then, of other robots' 98 in 100.
FROM_GUESS_FIRST = replace(solvers.FROM_GUESS, iterations=35)


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
        kind = solvers.by_name(solver)
        when_idle()
        layout = layout or layout_of(Jump(robot=robot.name, model=model), robot)
        made = make_model(model, robot, free_arms=layout.arm_joints > 0)
        self.formulation = Formulation(
            robot, made, layout, cached_solver(kind, of_jumps(made, layout, robot))
        )
        self.last: Attempt | None = None
        self._found = deque[Attempt](maxlen=KEPT)

    @property
    def solvers(self) -> tuple[solvers.Solver, ...]:
        """The one that it has."""
        return self.formulation.solvers

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
        """Layout of the solver's variables."""
        return self.formulation.layout

    def plan(
        self,
        jump: Jump,
        *,
        weights: Mapping[str, float] | None = None,
        limits: Mapping[str, float] | None = None,
        near: Plan | None = None,
        patient: bool = True,
        explains: bool = True,
        hurried: bool = False,
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
            patient: look for the nearest jump that can be planned where the request cannot at once;
                now and then that is the request itself. Otherwise the first attempts are all.
            explains: whether what the request would need is found out, by further solves.
            hurried: take the first nearer jump that is found, which may not be quite the nearest,
                and explain nothing: for a slider that moves.
            cancelled: called before and during every solve; true to stop.
            progress: called with each attempt and the solver's iterations.

        Raises:
            InputError: no robot here comes near to the request, or `near` is of no use for it.
            NotConverged: no attempt satisfied every constraint; carries the last one, and with
                patience and the default solver the nearest jump and the limits that stop the rest.
            Cancelled: `cancelled` was true.
        """
        robot, layout = self.formulation.robot, self.formulation.layout
        task = make_task(jump, robot, weights, limits)
        own = layout_of(jump, robot, limits=limits)
        if replace(own, intervals=layout.intervals) != layout:
            raise InputError(
                f"this planner plans as {layout.name}, the jump is to be planned as {own.name}; "
                "expected one of the same type (planner_of finds its planner)"
            )
        watch, start = Watch(cancelled, progress), time.perf_counter()
        watch.wait()
        looks = patient and self._has_nearest
        hurried = hurried and looks
        if hurried and near is not None:
            tried, nearest = self._from_near(task, near, watch)
        else:
            tried, nearest = self._from_scratch(task, near, looks, hurried, watch)
        if nearest is not None:
            whole = nearest.plain.task.jump == jump
            tried.append(replace(nearest.plain, label=BY_NEARER if whole else NEAREST))
        return self._ended(task, tried, nearest, start, explains and not hurried, watch)

    def _from_scratch(
        self,
        task: Task,
        near: Plan | None,
        looks: bool,
        hurried: bool,
        watch: Watch,
    ) -> tuple[list[Attempt], Nearest | None]:
        """Attempts at the request, and the nearest jump if all have failed and it is looked for."""
        if looks and near is not None and near.is_nearest:
            # What is asked now will hardly do where the request before did not.
            nearest = find_nearest(self.formulation, task, watch, self._less(task, near))
            if nearest is not None:
                return [], nearest
        tried: list[Attempt] = []
        for label, solve in self._attempts(task, near, looks, watch):
            watch.begin(f"attempt {len(tried) + 1}: {label}")
            tried.append(replace(self.formulation.reconciled(solve(), watch), label=label))
            if tried[-1].solved:
                return tried, None
            _log.info("attempt %d, %s, failed", len(tried), label)
        if not looks:
            return tried, None
        watch.begin("looking for the nearest jump that can be planned")
        find = first_feasible if hurried else find_nearest
        begun = task.jump, tried[-1].solution.variables
        return tried, find(self.formulation, task, watch=watch, begun=begun)

    def _from_near(
        self, task: Task, near: Plan, watch: Watch
    ) -> tuple[list[Attempt], Nearest | None]:
        """The same in a hurry: from a plan nearby, of all that was asked or of the nearest jump."""
        form, tried = self.formulation, list[Attempt]()
        start = usable_start(near, form)
        watch.begin(f"attempt 1: {FOLLOWED}")
        bounded = with_bounds_nearby(form, task, near.jump, start, self._found)
        if not near.is_nearest:
            attempt = form.reconciled(form.follow(bounded, start, watch), watch, hurried=True)
            if attempt.solved:
                return [replace(attempt, label=FOLLOWED)], None
            tried = [attempt]
        watch.begin("looking for the nearest jump that can be planned")
        begun = near.jump, start.variables
        found = first_feasible(form, bounded, begun, watch)
        if found is None and not tried:  # a refusal says where the request stopped
            tried = [form.follow(bounded, start, watch)]
        return tried, found

    def _ended(
        self,
        task: Task,
        tried: list[Attempt],
        nearest: Nearest | None,
        start: float,
        explains: bool,
        watch: Watch,
    ) -> Plan:
        """The plan of the request, or what is known instead."""
        at_request = [attempt for attempt in tried if attempt.task.jump == task.jump]
        if nearest is not None and not at_request:
            at_request = [self._not_tried(task, nearest.plain)]
        best, whole = best_of(at_request), any(attempt.solved for attempt in at_request)
        self.last = best if whole else None
        if whole:
            self._found.append(best)
        seconds = sum(attempt.solution.solve_time_s for attempt in tried)
        plan = self.formulation.plan(best, len(tried), seconds, start)
        if whole:
            return plan
        if nearest is None:
            raise unexplained(task, best, plan)
        less = self.formulation.plan(tried[-1], len(tried), seconds, start)
        raise refusal(nearest, task, plan, less, explains, watch)

    def _not_tried(self, task: Task, plain: Attempt) -> Attempt:
        """The motion of the nearest jump, as what it is of a request that was not tried."""
        there = replace(plain.solution, converged=False, iterations=0, solve_time_s=0.0)
        return replace(self.formulation.judged(task, there), label=NOT_TRIED)

    @property
    def _has_nearest(self) -> bool:
        """Whether less of a request can be asked for, see `answer.nearest`."""
        first = self.formulation.solver.name == solvers.names()[0]
        return first and self.layout.gives

    @staticmethod
    def _less(task: Task, near: Plan | None) -> tuple[Jump, Array] | None:
        """A plan's jump and variables, if it does no more of anything than the task asks."""
        if near is None or near.solution is None:
            return None
        pairs = [(getattr(near.jump, name), getattr(task.jump, name)) for name in COMPONENTS]
        less = all(min(all_, 0.0) <= done <= max(all_, 0.0) for done, all_ in pairs)
        return (near.jump, near.solution.variables) if less else None

    def _attempts(
        self, task: Task, near: Plan | None, hurried: bool, watch: Watch
    ) -> Iterator[tuple[str, Callable[[], Attempt]]]:
        """Label and solve of each attempt, in order; the next only when the one before failed.

        `hurried`: the nearest jump is looked for next, in which the request itself may be found.
        """
        guess = self.formulation.guess
        if near is not None:
            last = near.jump, usable_start(near, self.formulation)
            yield FOLLOWED, lambda: self._followed(task, *last, watch)
        options = FROM_GUESS_FIRST if hurried else solve_options(task)
        solve = partial(self.formulation.solve, task, guess(task), watch, options)
        yield "from the analytic guess", solve

    def _followed(self, task: Task, jump: Jump, start: Iterate, watch: Watch) -> Attempt:
        """The attempt from the solution of the last jump.

        The momentum of a body that turns over, and where its feet roll to, are never those of the
        model alone: without what the whole body says of the solution nearby that one is none.
        """
        if not task.jump.turns:
            return self.formulation.follow(task, start, watch)
        task = with_bounds_nearby(self.formulation, task, jump, start, self._found)
        return from_nearby(self.formulation, start, task, watch)

    def last_knots(self) -> Knots:
        """The last solution in full, for tests and studies."""
        if self.last is None:
            raise InputError("this planner has no solution yet")
        return self.last.knots


def planner_of(
    jump: Jump,
    solver: str = solvers.names()[0],
    intervals: int = INTERVALS,
    robot: Robot | None = None,
    cancelled: Callable[[], bool] | None = None,
    limits: Mapping[str, float] | None = None,
) -> Planner:
    """The planner of a jump's robot, model and type, built once and kept (`solve.kept`).

    It is built again when the robot's file, or that of the type, has changed.

    Args:
        jump: a request.
        solver: its name.
        intervals: as for three phases.
        robot: the one that the request names, with other drives (`llsrbm.robots.drives.variants`).
        cancelled: asked while it is built; True ends with `Cancelled` within 0.1 s.
        limits: of the request; those of the apex take a solver of their own.

    Raises:
        InputError: a whole turn about an axis about which the robot makes none.
        Cancelled: `cancelled` was true.
    """
    own = _own(jump, solver, intervals, robot, limits)
    return kept((Planner, *own), lambda: interruptible(partial(Planner, *own), cancelled))


def is_planner_built(jump: Jump, limits: Mapping[str, float] | None = None) -> bool:
    """Whether `planner_of` takes no building, but a few seconds to load at most; raises as that."""
    robot, model, _, layout = _own(jump, solvers.names()[0], INTERVALS, None, limits)
    made = make_model(model, robot, free_arms=layout.arm_joints > 0)
    return is_built(of_jumps(made, layout, robot))


def _own(
    jump: Jump,
    solver: str,
    intervals: int,
    robot: Robot | None,
    limits: Mapping[str, float] | None,
) -> tuple[Robot, str, str, Layout]:
    """All that the planner of a jump is made from."""
    # Rows are of the file's drives, whatever a request says of them.
    robot = with_strength(robot or load_robot(jump.robot))
    if jump.turns:
        robot = robot.turning
        check_turns(jump, robot)
    return robot, jump.model, solver, layout_of(jump, robot, intervals, limits)


def planner_for(
    robot: str, model: str, solver: str = solvers.names()[0], intervals: int = INTERVALS
) -> Planner:
    """The planner of a robot's name or file and a model's name, for jumps of the default type."""
    return planner_of(Jump(robot=robot, model=model), solver, intervals)
