"""Jumps of one robot with one model as optimal control problems: task in, solved motion out."""

import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from llsrbm.arrays import Array, IntArray
from llsrbm.mechanics import rotation_matrices
from llsrbm.models.base import CentroidalModel
from llsrbm.motion.plan import Plan
from llsrbm.motion.solve_report import SolveReport, Violation
from llsrbm.ocp.horizon import Iterate, Problem, Solution
from llsrbm.ocp.progress import solving
from llsrbm.ocp.solvers import FROM_GUESS, SolveOptions, Solver
from llsrbm.planning.problem.constraints import AGREED, CONSTRAINTS
from llsrbm.planning.problem.constraints.body_clearance import BodyClearance
from llsrbm.planning.problem.constraints.edge import Edge
from llsrbm.planning.problem.constraints.shortfall import ROOM, Shortfall, most
from llsrbm.planning.problem.constraints.truth import Rolling, TrueTurn, correction
from llsrbm.planning.problem.jump_horizon import (
    evaluated_rows,
    make_problem,
    rolled_out,
    row_places,
)
from llsrbm.planning.problem.knots import DYNAMICS, Knots, unpack
from llsrbm.planning.problem.layout import NEXT_SHORTFALL, SHORTFALL, Layout
from llsrbm.planning.problem.limits import limits_in
from llsrbm.planning.problem.placement import retargeted
from llsrbm.planning.problem.shortfall import shortfall_parameters
from llsrbm.planning.problem.task import Task
from llsrbm.planning.problem.violations import TOLERANCE, excess, satisfied, violations
from llsrbm.planning.solve.guess import analytic_guess
from llsrbm.planning.solve.solver_cache import is_compiling
from llsrbm.planning.solve.watch import Watch
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.robots.robot import Robot

# Solves from a near solution before planning starts from a guess instead. The second corrects small
# violations that the first leaves: a bound passed by a long step, or rows that Fatrop had scaled.
MAX_FOLLOWS = 2
# Where following creeps.
FROM_CLOSE = replace(FROM_GUESS, mu=1e-3, push=0.01, iterations=60)
# Constraints that solving again with what the whole body does may satisfy.
CORRECTED = frozenset({TrueTurn.name, Rolling.name})
_SHORTFALL = next(c for c in CONSTRAINTS if isinstance(c, Shortfall))
# Constraints that `reconciled` may satisfy by solving again with the results of the check. Of a
# nearer jump another edge may bound the feet.
MENDED = frozenset(c.name for c in AGREED) | CORRECTED
MENDED_NEARER = MENDED | {Edge.name, BodyClearance.name}
# Such solves; each takes the error down by some nine tenths.
MAX_CORRECTIONS = 3
# Solves with shifted bounds of drives and stops; one is enough for most. Each has to take the
# excess down to this share of what it was.
MAX_SHIFTS = 6
MAX_SHIFTS_NEARER = 2  # where less may be done: all of what that does is solved after these
MAX_SHRINK = 0.8
# Excess up to which following is tried first: from further off one in fifteen gets there so.
MAX_EXCESS_FOLLOWED = 0.2
# Where less may be done, with what the whole body says: 14 to 49 iterations, where the options of
# `answer.nearest` take 23 to 61.
NEARER_AGAIN = replace(FROM_GUESS, iterations=80, mu=1e-3, push=1e-3)
# From a flip's guess Fatrop may get lost and never come back; those that converge take 40 to 60.
# The larger push takes fewer; with flight times from 20 % below the guess's to 20 % above 19 of 20
# are found.
FROM_FLIP_GUESS = replace(FROM_GUESS, iterations=75, push=0.2)


def solve_options(task: Task) -> SolveOptions:
    """Start and end of a task's solve from a guess."""
    return FROM_FLIP_GUESS if task.jump.turns else FROM_GUESS


@dataclass(frozen=True, eq=False)
class Attempt:
    """A solve of a task, and the motion it ended with.

    Attributes:
        violations: of the motion, recomputed.
        label: from where it began, in words.
    """

    task: Task
    solution: Solution
    knots: Knots
    violations: dict[str, Violation]
    label: str = ""

    @property
    def converged(self) -> bool:
        """True if the solver ended at an optimum of the rows."""
        return self.solution.converged

    @property
    def solved(self) -> bool:
        """True if the solver converged and the motion satisfies every constraint.

        A draft that is only where the whole body's problem begins need not be the best one.
        """
        return (self.converged or not self.task.agrees) and satisfied(self.violations)

    @property
    def broken(self) -> set[str]:
        """Names of the constraints that a solution violates; none unless it converged."""
        names = {name for name, v in self.violations.items() if v.amount > TOLERANCE}
        return names if self.converged else set()


def corrected(last: Attempt) -> Task:
    """An attempt's task, with the momentum of the whole body, and its feet where they roll to."""
    rolled = last.knots.rolled if last.knots.layout.turns else None
    return replace(last.task, correction=correction(last.knots), rolled=rolled)


def best_of(attempts: Sequence[Attempt]) -> Attempt:
    """The attempt that is solved, else of those that converged, else of all the one that violates
    least; its time is that of all of them.
    """
    best = min(attempts, key=lambda a: (not a.solved, not a.converged, excess(a.violations)))
    seconds = sum(attempt.solution.solve_time_s for attempt in attempts)
    return replace(best, solution=replace(best.solution, solve_time_s=seconds))


@dataclass(frozen=True, eq=False)
class Formulation:
    """Robot, model, variables and solver of a kind of jumps; nothing of a solve is kept."""

    robot: Robot
    model: CentroidalModel
    layout: Layout
    solver: Solver

    @property
    def solvers(self) -> tuple[Solver, ...]:
        """The one that it has."""
        return (self.solver,)

    def problem(self, task: Task) -> Problem:
        """The task's numbers."""
        return make_problem(self.layout, task)

    def guess(self, task: Task) -> Array:
        """All variables."""
        return analytic_guess(task, self.layout, self.model)

    def moved(self, near: Attempt, task: Task) -> Array:
        """A guess: another task's solution, moved as the analytic guesses of the two differ."""
        w = near.solution.variables + self.guess(task) - self.guess(near.task)
        return self.layout.normalised(w)

    def solve(
        self, task: Task, guess: Array, watch: Watch, options: SolveOptions = FROM_GUESS
    ) -> Attempt:
        """Solve from a guess."""
        solve = partial(self.solver.solve, self.problem(task), guess, options, watch.read)
        return self.judged(task, watch.over(solve))

    def follow(self, task: Task, start: Iterate, watch: Watch) -> Attempt:
        """Solve from a near solution."""
        problem = self.problem(task)
        attempts: list[Attempt] = []
        for _ in range(MAX_FOLLOWS):
            solve = partial(self.solver.follow, problem, start)
            last = self.judged(task, watch.over(solve))
            attempts.append(last)
            # Where only the check of the whole body objects, the same rows give the same again.
            if last.solved or last.broken <= mended(task):
                break
            start = last.solution
        return best_of(attempts)

    def reconciled(self, attempt: Attempt, watch: Watch, *, hurried: bool = False) -> Attempt:
        """The best of an attempt and of solves after it, until model and whole body agree.

        It is solved again where the two alone differ.

        The legs' maps are a few per cent wrong far from where they were fitted, which a body that
        turns over shows as a dozen degrees: the whole body's angular momentum in the postures found
        says by how much. The rows of drives and stops are approximations: their bounds are shifted
        by what they differ from the whole body's torques, speeds and angles.
        """
        attempts = [attempt]
        while len(attempts) <= MAX_CORRECTIONS and attempts[-1].broken & CORRECTED:
            last = attempts[-1]
            task = corrected(last)
            # A flip that is solved from far again ends in another motion, with another correction.
            options = FROM_CLOSE if task.jump.turns else FROM_GUESS
            attempts.append(self.solve(task, last.solution.variables, watch, options))
        last = attempts[-1]
        for _ in range(MAX_SHIFTS_NEARER if last.task.penalty else MAX_SHIFTS):
            if not last.broken or not last.broken <= mended(last.task):
                break
            task = self.with_shifted_bounds(last)
            near = excess(last.violations) < MAX_EXCESS_FOLLOWED
            attempts.append(self.again(task, last.solution, watch, near, hurried=hurried))
            before, last = last, attempts[-1]
            if excess(last.violations) > MAX_SHRINK * excess(before.violations):
                break
        return best_of(attempts)

    def with_shifted_bounds(self, last: Attempt) -> Task:
        """An attempt's task, with what the whole body says of its motion in the rows' bounds."""
        bounds = {c.name: c.agreed_bounds(last.knots) for c in AGREED}
        task = replace(last.task, agreed_bounds=bounds)
        if task.correction is not None or last.broken & CORRECTED:
            task = corrected(replace(last, task=task))
        return task

    def with_bounds_of_start(
        self, task: Task, start: Iterate, known: Iterable[Attempt] = ()
    ) -> Task:
        """A task, with what the whole body says of a solution from which solving it begins.

        `known`: attempts, one of which may have this solution; it is not judged again then.
        """
        for attempt in known:
            if np.array_equal(attempt.solution.variables, start.variables):
                judged = replace(attempt, task=task, knots=attempt.knots.under(task))
                return self.with_shifted_bounds(judged)
        there = Solution(
            variables=start.variables,
            multipliers=start.multipliers,
            converged=True,
            iterations=0,
            cost=0.0,
            solve_time_s=0.0,
            violation=0.0,
            message="a start",
        )
        return self.with_shifted_bounds(self.judged(task, there))

    def again(
        self, task: Task, last: Iterate, watch: Watch, near: bool = True, *, hurried: bool = False
    ) -> Attempt:
        """Solve a task whose numbers differ a little from those of a solution's.

        `near`: so little that following may do. `hurried`: no more than that is tried then. Where
        less may be done what is given up changes too much for following.
        """
        if task.penalty:
            return self.solve(task, last.variables, watch, NEARER_AGAIN)
        tried = [self.follow(task, last, watch)] if near else []
        if not tried or not (tried[-1].converged or hurried):
            tried.append(self.solve(task, last.variables, watch, FROM_CLOSE))
        return best_of(tried)

    def plan(self, attempt: Attempt, attempts: int, solve_time: float, begun: float) -> Plan:
        """The plan of the best of several attempts.

        Args:
            attempt: the best.
            attempts, solve_time: their number, and the time in the solver, s.
            begun: when the first began, of `time.perf_counter`, s.
        """
        task, knots, solution = attempt.task, attempt.knots, attempt.solution
        arrays = knot_arrays(knots) | knots.loads.at_knots()
        report = SolveReport(
            status="solved" if attempt.solved else "not-converged",
            solver=self.solver.name,
            iterations=solution.iterations,
            attempts=attempts,
            solve_time_s=solve_time,
            total_time_s=time.perf_counter() - begun,
            build_time_s=0.0,
            cost=solution.cost,
            guess=attempt.label,
            compiling=is_compiling(self.solver),
        )
        return Plan(
            jump=task.jump,
            tuning=task.tuning,
            limits={name: value for name, (_, value) in limits_in(task).items()},
            robot_parameters=self.robot.parameters(),
            violations=attempt.violations,
            base_mass=knots.model.base_mass,
            joint_names=self.robot.joint_names,
            schedule=task.schedule,
            obstacle=task.obstacle,
            solution=Iterate(solution.variables, solution.multipliers) if attempt.solved else None,
            report=report,
            **arrays,
        )

    def constraint_values(self, w: Array, parameters: Array) -> Array:
        """All rows g of the problem, while no solver runs."""
        with solving:
            return np.array(self.solver.function("nlp_g")(w, parameters)).ravel()

    def judged(self, task: Task, solution: Solution) -> Attempt:
        """The motion of a solution, checked as one of the jump that it does."""
        task = retargeted(task, self.done(task, solution.variables)) if task.penalty else task
        evaluate = partial(evaluated_rows, self.layout, self.constraint_values)
        with np.errstate(all="ignore"):  # a solver that diverges leaves what is no number
            w = rolled_out(self.layout, lambda w: evaluate(task, w)[DYNAMICS], solution.variables)
            knots = unpack(w, self.layout, task, self.model, evaluate)
            return Attempt(task, solution, knots, violations(knots))

    def done(self, task: Task, variables: Array) -> Jump:
        """The jump that a solution does."""
        numbers = shortfall_parameters(self.layout, task)
        shortfall = np.maximum(variables[self._shortfall[-1]], 0.0)
        reached = numbers["asked"] - numbers["scale"] * shortfall
        return replace(task.jump, **dict(zip(COMPONENTS, reached.tolist(), strict=True)))

    def with_less(self, task: Task, variables: Array, jump: Jump) -> Array:
        """All variables of a jump that does less than the task asks, as those of the task."""
        numbers = shortfall_parameters(self.layout, task)
        reached = np.array([getattr(jump, name) for name in COMPONENTS])
        less, scale = numbers["asked"] - reached, numbers["scale"]
        shortfall = np.divide(less, scale, out=np.zeros_like(less), where=scale != 0)
        out = variables.copy()
        out[self._shortfall] = np.clip(shortfall, 0.0, most(self.layout, task))
        return out

    def whole(self, task: Task, solution: Iterate) -> Iterate:
        """A solution as one of the jump that it does, of which nothing is given up.

        What is given up changes nothing then: it is in the middle of its bounds, where solves leave
        it, and its rows are worth nothing. From a bound an uncompiled Fatrop may never come back.
        """
        variables, multipliers = solution.variables.copy(), solution.multipliers.copy()
        variables[self._shortfall] = ROOM / 2
        places, _ = row_places(self.layout, task)
        for rows in (SHORTFALL, _SHORTFALL):
            multipliers[places[rows]] = 0.0
        return Iterate(variables, multipliers)

    @cached_property
    def _shortfall(self) -> IntArray:
        """(n, 4) places of what is given up; the first of its choice, the others of the states."""
        return np.vstack([self.layout.places(NEXT_SHORTFALL), self.layout.places(SHORTFALL)])


def mended(task: Task) -> frozenset[str]:
    """Constraints that `reconciled` may satisfy by solving again with the results of the check."""
    return MENDED_NEARER if task.penalty else MENDED


def scaled(jump: Jump, share: float) -> Jump:
    """A share of the request's displacement; whole turns, speeds and hops stay."""
    motion = {k: share * getattr(jump, k) for k in ("twist", "forward", "lateral", "height")}
    return replace(jump, **motion)


def knot_arrays(knots: Knots) -> dict[str, Any]:
    """Name -> array of what a plan has at its knots, but for the joints' loads."""
    task, R = knots.task, rotation_matrices(knots.quat)
    # Knot values of the interval rates: the mean of both beside it, at rest at the ends, but for
    # those of a run-up, a landing that keeps some speed, and a motion that is under way.
    rate = np.zeros_like(knots.position)
    starts_moving = task.motion is not None or task.start_velocity.any()
    for end, moves in ((0, starts_moving), (-1, task.goal_velocity.any())):
        if moves:
            rate[end] = knots.rotation_rate[end]
    rate[1:-1] = (knots.rotation_rate[:-1] + knots.rotation_rate[1:]) / 2
    return {
        "time": knots.time,
        "phase": knots.phase,
        "com": knots.position,
        "com_velocity": knots.velocity,
        "base_quat": knots.quat,
        "base_position": knots.postures.base_position,
        "angular_velocity": np.einsum("kij,kj->ki", R, rate),
        "linear_momentum": knots.velocity * task.mass,
        "angular_momentum": knots.momentum,
        "inertia": R @ knots.inertia @ R.transpose(0, 2, 1),
        "foot_position": knots.foot_position,
        "foot_quat": knots.foot_quat,
        "contact_point": knots.contact_point,
        "contact_force": knots.force,
        "leg_mass": knots.model.leg_mass,
        "leg_com": knots.position[:, None] + np.einsum("kij,klj->kli", R, knots.leg_com),
        "joint_position": knots.postures.joint_position,
        "foot_in_hip": knots.feet_in_hip,
    }
