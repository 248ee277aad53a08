"""The nearest jump that can be planned: the elastic problem solved, and its jump made round.

Types with whole turns, and motions that are under way, have none: a turn is whole or it is none,
and a motion under way lands where it can already. Several displacements that follow the
request are reduced alike.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from llsrbm.arrays import Array, IntArray
from llsrbm.errors import NoFooting
from llsrbm.ocp import solvers
from llsrbm.ocp.horizon import Iterate, Problem, Solution
from llsrbm.planning.problem.clearance_profile import check_footing
from llsrbm.planning.problem.constraints.body_clearance import BodyClearance
from llsrbm.planning.problem.constraints.edge import Edge
from llsrbm.planning.problem.constraints.shortfall import most
from llsrbm.planning.problem.elastic import (
    NEXT_SHORTFALL,
    SHORTFALL,
    ElasticLayout,
    elastic_parameters,
)
from llsrbm.planning.problem.jump_horizon import rows_within
from llsrbm.planning.problem.parameters import parameter_places
from llsrbm.planning.problem.placement import place_task
from llsrbm.planning.problem.task import Task
from llsrbm.planning.problem.violations import excess
from llsrbm.planning.solve.formulation import (
    MAX_EXCESS_FOLLOWED,
    Attempt,
    Formulation,
    scaled,
)
from llsrbm.planning.solve.solver_cache import cached_solver, of_jumps
from llsrbm.planning.solve.watch import Watch
from llsrbm.request.jump import COMPONENTS, Jump

# rad and m: results are whole steps of the components that are reduced.
STEPS = {"twist": math.radians(1.0), "forward": 0.01, "lateral": 0.01, "height": 0.01}
GUESSED_SHARE = 0.5  # share of the request that is guessed
# Costs of a whole range that is given up. With the first a solve gets there, with the second it
# keeps what is merely expensive: 14 to 20 degrees of hard jumps.
PENALTIES = (200.0, 600.0)
# One with which the corners of the range get somewhere, too; it gives up more than has to be.
LOW_PENALTY = 30.0
LEAST_SHORTFALL = 1e-3  # of a range; what is given up below it may be nothing
SHORTFALL_AT_LIMITS = 0.015  # likewise, where what the rows keep of the limits counts
# More of what is given up, in shares of the ranges, where the first whole steps are too many. The
# elastic solution gives up a millimetre of what is to be kept; a step less of the rest pays for it.
EXTRA_SHORTFALLS_SOLVED = (0.0, 0.003)
# Where the whole body objects to it as it is, much more.
EXTRA_SHORTFALLS = (0.0, 0.015, 0.05)
# Of the ranges: where that much is given up another start may lead to less. From a guess without it
# seven of ANYmal's corners, of twists of 180 degrees, keep up to 43 degrees more, and none less.
LARGE_SHORTFALL = 0.15
ELASTIC_FROM_GUESS = replace(solvers.FROM_GUESS, mu=0.1, iterations=100)
# From where the plain problem was given up: 21 to 36 iterations, from the first guess 39 to 74.
ELASTIC_FROM_PLAIN = replace(solvers.FROM_GUESS, iterations=50)
ELASTIC_DEARER = replace(solvers.FROM_GUESS, iterations=80)  # 28 to 63 are needed
# With the same penalty, and what the whole body says: 14 to 49, where the one above takes 23 to 61.
ELASTIC_AGAIN = replace(ELASTIC_DEARER, mu=1e-3, push=1e-3)


@dataclass(frozen=True, eq=False)
class ElasticFormulation(Formulation):
    """The same jumps, with what is given up of a request as a variable.

    Its attempts have tasks of the jumps that they do, judged as those are; their solutions are of
    the elastic problem.

    Attributes:
        plain: the formulation of these jumps.
        penalty: of a whole range that is given up.
    """

    plain: Formulation
    penalty: float = PENALTIES[-1]
    # The plain problem goes on where these leave something.
    shifts = 2
    # Of a nearer jump another edge may bound the feet.
    mended = Formulation.mended | {Edge.name, BodyClearance.name}

    @classmethod
    def of(cls, plain: Formulation, layout: ElasticLayout) -> ElasticFormulation:
        """Beside a formulation, its solver loaded or built."""
        solver = cached_solver(type(plain.solver), of_jumps(plain.model, layout, plain.robot))
        return cls(plain.robot, plain.model, layout, solver, plain)

    def problem(self, task: Task) -> Problem:
        """The task's numbers."""
        problem = super().problem(task)
        problem.parameters[parameter_places(self.layout)["penalty"]] = self.penalty
        return problem

    def judged(self, task: Task, solution: Solution) -> Attempt:
        """The motion of a solution, checked as one of the jump that it does."""
        reached = retargeted(task, self.done(task, solution.variables))
        plain = replace(solution, **vars(self.to_plain(task, solution)))
        return replace(self.plain.judged(reached, plain), solution=solution)

    def again(
        self, task: Task, last: Iterate, watch: Watch, near: bool = True, *, hurried: bool = False
    ) -> Attempt:
        """Not followed: what is given up changes too much for that."""
        return self.solve(task, last.variables, watch, ELASTIC_AGAIN)

    def done(self, task: Task, variables: Array) -> Jump:
        """The jump that a solution does."""
        numbers = elastic_parameters(self._layout, task)
        shortfall = np.maximum(variables[self._shortfall[-1]], 0.0)
        reached = numbers["asked"] - numbers["scale"] * shortfall
        return replace(task.jump, **dict(zip(COMPONENTS, reached.tolist(), strict=True)))

    def to_elastic(self, task: Task, variables: Array, jump: Jump) -> Array:
        """All variables, from those of a plain problem with a jump that does less than asked."""
        numbers = elastic_parameters(self._layout, task)
        reached = np.array([getattr(jump, name) for name in COMPONENTS])
        less, scale = numbers["asked"] - reached, numbers["scale"]
        shortfall = np.divide(less, scale, out=np.zeros_like(less), where=scale != 0)
        out = np.zeros(self.layout.size_total)
        out[self._variables] = variables
        out[self._shortfall] = np.clip(shortfall, 0.0, most(self._layout, task))
        return out

    def to_plain(self, task: Task, solution: Iterate) -> Iterate:
        """Variables and multipliers of the plain problem."""
        rows = rows_within(self.plain.layout, self.layout, task)
        return Iterate(solution.variables[self._variables], solution.multipliers[rows])

    @property
    def _layout(self) -> ElasticLayout:
        assert isinstance(self.layout, ElasticLayout)
        return self.layout

    @cached_property
    def _variables(self) -> IntArray:
        """Places of the plain problem's variables."""
        pairs = [
            (self.layout.variables(knot)[name], place)
            for knot in range(self.layout.knots)
            for name, place in self.plain.layout.variables(knot).items()
        ]
        return np.concatenate([np.arange(mine.start, mine.stop) for mine, _ in pairs])

    @cached_property
    def _shortfall(self) -> IntArray:
        """(n, 4) places of what is given up; the first of its choice, the others of the states."""
        return np.vstack([self.layout.places(NEXT_SHORTFALL), self.layout.places(SHORTFALL)])


@dataclass(frozen=True, eq=False)
class Nearest:
    """The nearest jump that can be planned.

    Attributes:
        plain: it, solved.
        elastic: the solution of the elastic problem, which knows what stops the rest.
        formulation: of the elastic problem.
    """

    plain: Attempt
    elastic: Attempt
    formulation: ElasticFormulation


def find_nearest(
    formulation: ElasticFormulation,
    task: Task,
    watch: Watch,
    begun: tuple[Jump, Array] | None = None,
) -> Nearest | None:
    """The nearest jump to a task's; None: not even a small share of it can be planned.

    Args:
        formulation: of the elastic problem.
        task: the request's.
        watch: reports and cancels.
        begun: a jump that does no more, and all plain variables of its solution, or of where that
            was given up, to start from.

    Raises:
        Cancelled: it is not wanted any more.
    """
    for start, options, penalty in starts(formulation, task, begun):
        way = replace(formulation, penalty=penalty)
        elastic = way.solve(task, start, watch, options)
        if elastic.converged:
            break
    else:
        return None
    if distance(task, elastic.task.jump) > LARGE_SHORTFALL:
        elastic = _from_other_end(way, task, elastic, watch)
    first = None
    if not _falls_short(elastic) and excess(elastic.violations) < MAX_EXCESS_FOLLOWED:
        first = _in_whole_steps(way, elastic, watch)
        if first is not None and first.task.jump == task.jump:
            return Nearest(first, elastic, way)
    found = [] if first is None else [Nearest(first, elastic, way)]
    for dearer, attempt in reversed([*_dearer(way, elastic, watch)]):
        reconciled = dearer.reconciled(attempt, watch)
        plain = _in_whole_steps(dearer, reconciled, watch)
        if plain is not None:
            found.append(Nearest(plain, reconciled, dearer))
            break
    if not found:
        # Edges come and go with the jump; the first solution met those that it knew.
        plain = _in_whole_steps(way, elastic, watch)
        found = [] if plain is None else [Nearest(plain, elastic, way)]
    return min(found, key=lambda each: distance(task, each.plain.task.jump), default=None)


def _from_other_end(way: ElasticFormulation, task: Task, elastic: Attempt, watch: Watch) -> Attempt:
    """The cheaper of a solution and of one from a guess without what that one gives up most."""
    own, reached = task.robot.file.task, elastic.task.jump
    missing = {
        name: abs(getattr(task.jump, name) - getattr(reached, name)) / ((high - low) or 1.0)
        for name, (low, high) in ((name, getattr(own, name)) for name in COMPONENTS)
    }
    without: dict[str, Any] = {max(missing, key=missing.__getitem__): 0.0}
    less = replace(task.jump, **without)
    guess = way.to_elastic(task, way.plain.guess(retargeted(task, less)), less)
    other = way.solve(task, guess, watch, ELASTIC_FROM_GUESS)
    return min((elastic, other), key=lambda each: (not each.converged, each.solution.cost))


def _dearer(
    way: ElasticFormulation, elastic: Attempt, watch: Watch
) -> Iterator[tuple[ElasticFormulation, Attempt]]:
    """A solution, and those after it of ever higher penalties, as long as they converge.

    Each knows what the whole body says of the one before.
    """
    yield way, elastic
    for penalty in (penalty for penalty in PENALTIES if penalty > way.penalty):
        way = replace(way, penalty=penalty)
        elastic = way.solve(
            way.with_shifted_bounds(elastic), elastic.solution.variables, watch, ELASTIC_DEARER
        )
        if not elastic.converged:
            return
        yield way, elastic


def starts(
    formulation: ElasticFormulation, task: Task, begun: tuple[Jump, Array] | None
) -> Iterator[tuple[Array, solvers.SolveOptions, float]]:
    """Variables, options and penalty of one start after another."""
    if begun is not None:
        jump, variables = begun
        yield formulation.to_elastic(task, variables, jump), ELASTIC_FROM_PLAIN, PENALTIES[0]
    less = scaled(task.jump, GUESSED_SHARE)
    guess = formulation.to_elastic(task, formulation.plain.guess(retargeted(task, less)), less)
    for penalty in (PENALTIES[0], LOW_PENALTY):
        yield guess, ELASTIC_FROM_GUESS, penalty


def _in_whole_steps(
    formulation: ElasticFormulation, elastic: Attempt, watch: Watch
) -> Attempt | None:
    """The plain problem's solution: of whole steps, or else just as it is.

    Of some steps less where the whole body objects to it as it is.
    """
    plain, whole = formulation.plain, attempt_at_request(formulation, elastic)
    if whole.task.jump == elastic.task.requested and whole.solved and stands(whole.task):
        return whole
    start = formulation.to_plain(elastic.task, elastic.solution)
    shifted = formulation.with_shifted_bounds(elastic) if elastic.broken else elastic.task
    all_right = elastic.solved and stands(elastic.task)
    further = EXTRA_SHORTFALLS_SOLVED if all_right else EXTRA_SHORTFALLS
    for jump in _rounded(elastic.task, further) if elastic.converged else ():
        task = replace(retargeted(shifted, jump), requested=None)
        attempt = plain.reconciled(plain.again(task, start, watch), watch)
        if attempt.solved and stands(attempt.task):
            return attempt
    return plain_attempt(formulation, elastic) if all_right else None


def plain_attempt(formulation: ElasticFormulation, elastic: Attempt) -> Attempt:
    """The plain problem's solution that an elastic one holds."""
    plain = vars(formulation.to_plain(elastic.task, elastic.solution))
    task, solution = replace(elastic.task, requested=None), replace(elastic.solution, **plain)
    return replace(elastic, task=task, solution=solution)


def attempt_at_request(formulation: ElasticFormulation, elastic: Attempt) -> Attempt:
    """An elastic solution as one of what was asked: it is that where nothing is given up."""
    requested, plain = elastic.task.requested, plain_attempt(formulation, elastic)
    if requested is None or _falls_short(elastic):
        return plain
    task = replace(retargeted(elastic.task, requested), requested=None)
    return formulation.plain.judged(task, plain.solution)


def _falls_short(elastic: Attempt) -> bool:
    """Whether the jump of an elastic problem's solution does less than was asked."""
    return distance(elastic.task, elastic.task.jump) > LEAST_SHORTFALL


def stands(task: Task) -> bool:
    """Whether all feet land on something."""
    try:
        check_footing(task)
    except NoFooting:
        return False
    return True


def distance(task: Task, jump: Jump) -> float:
    """Distance of a jump from a task's request: components as shares of the robot's ranges."""
    requested, own = task.requested or task.jump, task.robot.file.task
    shares = (
        (getattr(requested, name) - getattr(jump, name)) / ((high - low) or 1.0)
        for name, (low, high) in ((name, getattr(own, name)) for name in COMPONENTS)
    )
    return math.hypot(*shares)


def _rounded(task: Task, furthers: Iterable[float]) -> Iterator[Jump]:
    """Jumps of whole steps near a task's: what was asked if that is near, the next less, and less.

    A component counts as given up where it is off by more than half a step. `furthers`: shares of
    the ranges by which less is asked for.
    """
    requested, reached = task.requested, task.jump
    assert requested is not None
    if distance(task, reached) <= SHORTFALL_AT_LIMITS:
        yield requested
    for further in furthers if distance(task, reached) > LEAST_SHORTFALL else ():
        steps = {}
        for name, step in STEPS.items():
            whole, value = getattr(requested, name), getattr(reached, name)
            steps[name] = whole
            if abs(whole - value) > step / 2:
                low, high = getattr(task.robot.file.task, name)
                left = max(abs(value) - further * (high - low), 0.0)
                steps[name] = math.copysign(math.floor(left / step + 1e-6) * step, whole)
        yield replace(requested, **steps)


def retargeted(task: Task, jump: Jump) -> Task:
    """The task of another jump, under the same limits; what it was asked for is kept."""
    return replace(
        place_task(jump, task.robot, task.tuning),
        limits=task.limits,
        reach=task.reach,
        timing=task.timing,
        foot=task.foot,
        body_margin=task.body_margin,
        apex=task.apex,
        correction=task.correction,
        agreed_bounds=task.agreed_bounds,
        requested=task.requested or task.jump,
    )
