"""The nearest jump that can be planned: solved where less may be done at a price, and made round.

Types with whole turns, and motions that are under way, have none: a turn is whole or it is none,
and a motion under way lands where it can already. Several displacements that follow the
request are reduced alike.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from llsrbm.arrays import Array
from llsrbm.errors import NoFooting
from llsrbm.ocp import solvers
from llsrbm.planning.problem.clearance_profile import check_footing
from llsrbm.planning.problem.placement import retargeted
from llsrbm.planning.problem.shortfall import distance
from llsrbm.planning.problem.task import Task
from llsrbm.planning.problem.violations import excess
from llsrbm.planning.solve.formulation import (
    MAX_EXCESS_FOLLOWED,
    Attempt,
    Formulation,
    scaled,
)
from llsrbm.planning.solve.watch import Watch
from llsrbm.request.jump import COMPONENTS, STEPS, Jump

GUESSED_SHARE = 0.5  # share of the request that is guessed
# Costs of a whole range that is given up. With the first a solve gets there, with the second it
# keeps what is merely expensive: 14 to 20 degrees of hard jumps.
PENALTIES = (200.0, 600.0)
# One with which the corners of the range get somewhere, too; it gives up more than has to be.
LOW_PENALTY = 30.0
LEAST_SHORTFALL = 1e-3  # of a range; what is given up below it may be nothing
SHORTFALL_AT_LIMITS = 0.015  # likewise, where what the rows keep of the limits counts
# More of what is given up, in shares of the ranges, where the first whole steps are too many. The
# solution gives up a millimetre of what is to be kept; a step less of the rest pays for it.
EXTRA_SHORTFALLS_SOLVED = (0.0, 0.003)
# Where the whole body objects to it as it is, much more.
EXTRA_SHORTFALLS = (0.0, 0.015, 0.05)
# Of the ranges: where that much is given up another start may lead to less. From a guess without it
# seven of ANYmal's corners, of twists of 180 degrees, keep up to 43 degrees more, and none less.
LARGE_SHORTFALL = 0.15
NEARER_FROM_GUESS = replace(solvers.FROM_GUESS, mu=0.1, iterations=100)
# From where the request was given up: 21 to 36 iterations, from the first guess 39 to 74.
NEARER_FROM_TRIED = replace(solvers.FROM_GUESS, iterations=50)
NEARER_DEARER = replace(solvers.FROM_GUESS, iterations=80)  # 28 to 63 are needed


@dataclass(frozen=True, eq=False)
class Nearest:
    """The nearest jump that can be planned.

    Attributes:
        plain: it, solved.
        priced: the solution in which less might be done, which knows what stops the rest.
        formulation: of both.
    """

    plain: Attempt
    priced: Attempt
    formulation: Formulation


def find_nearest(
    form: Formulation,
    task: Task,
    watch: Watch,
    begun: tuple[Jump, Array] | None = None,
) -> Nearest | None:
    """The nearest jump to a task's; None: not even a small share of it can be planned.

    Args:
        form: of such jumps.
        task: the request's.
        watch: reports and cancels.
        begun: a jump that does no more, and all variables of its solution, or of where that
            was given up, to start from.

    Raises:
        Cancelled: it is not wanted any more.
    """
    for start, options, priced_task in starts(form, task, begun):
        priced = form.solve(priced_task, start, watch, options)
        if priced.converged:
            break
    else:
        return None
    if distance(task, priced.task.jump) > LARGE_SHORTFALL:
        priced = _from_other_end(form, priced_task, priced, watch)
    first = None
    if not _falls_short(priced) and excess(priced.violations) < MAX_EXCESS_FOLLOWED:
        first = _in_whole_steps(form, priced, watch)
        if first is not None and first.task.jump == task.jump:
            return Nearest(first, priced, form)
    found = [] if first is None else [Nearest(first, priced, form)]
    for attempt in reversed([*_dearer(form, priced, watch)]):
        reconciled = form.reconciled(attempt, watch)
        plain = _in_whole_steps(form, reconciled, watch)
        if plain is not None:
            found.append(Nearest(plain, reconciled, form))
            break
    if not found:
        # Edges come and go with the jump; the first solution met those that it knew.
        plain = _in_whole_steps(form, priced, watch)
        found = [] if plain is None else [Nearest(plain, priced, form)]
    return min(found, key=lambda each: distance(task, each.plain.task.jump), default=None)


def _from_other_end(form: Formulation, task: Task, priced: Attempt, watch: Watch) -> Attempt:
    """The cheaper of a solution and of one from a guess without what that one gives up most."""
    own, reached = task.robot.file.task, priced.task.jump
    missing = {
        name: abs(getattr(task.jump, name) - getattr(reached, name)) / ((high - low) or 1.0)
        for name, (low, high) in ((name, getattr(own, name)) for name in COMPONENTS)
    }
    without: dict[str, Any] = {max(missing, key=missing.__getitem__): 0.0}
    less = replace(task.jump, **without)
    guess = form.with_less(task, form.guess(retargeted(task, less)), less)
    other = form.solve(task, guess, watch, NEARER_FROM_GUESS)
    return min((priced, other), key=lambda each: (not each.converged, each.solution.cost))


def _dearer(form: Formulation, priced: Attempt, watch: Watch) -> Iterator[Attempt]:
    """A solution, and those after it of ever higher penalties, as long as they converge.

    Each knows what the whole body says of the one before.
    """
    yield priced
    for penalty in (penalty for penalty in PENALTIES if penalty > priced.task.penalty):
        task = replace(form.with_shifted_bounds(priced), penalty=penalty)
        priced = form.solve(task, priced.solution.variables, watch, NEARER_DEARER)
        if not priced.converged:
            return
        yield priced


def starts(
    form: Formulation, task: Task, begun: tuple[Jump, Array] | None
) -> Iterator[tuple[Array, solvers.SolveOptions, Task]]:
    """Variables and options of one start after another, and the task at its price."""
    priced = replace(task, penalty=PENALTIES[0])
    if begun is not None:
        jump, variables = begun
        yield form.with_less(priced, variables, jump), NEARER_FROM_TRIED, priced
    less = scaled(task.jump, GUESSED_SHARE)
    guess = form.with_less(priced, form.guess(retargeted(task, less)), less)
    for penalty in (PENALTIES[0], LOW_PENALTY):
        yield guess, NEARER_FROM_GUESS, replace(task, penalty=penalty)


def _in_whole_steps(form: Formulation, priced: Attempt, watch: Watch) -> Attempt | None:
    """All of a jump that does less: of whole steps, or else just as it is.

    Of some steps less where the whole body objects to it as it is.
    """
    whole = attempt_at_request(form, priced)
    if whole.task.jump == priced.task.requested and whole.solved and stands(whole.task):
        return whole
    start = form.whole(priced.task, priced.solution)
    shifted = form.with_shifted_bounds(priced) if priced.broken else priced.task
    all_right = priced.solved and stands(priced.task)
    further = EXTRA_SHORTFALLS_SOLVED if all_right else EXTRA_SHORTFALLS
    for jump in _rounded(priced.task, further) if priced.converged else ():
        task = _all_of(retargeted(shifted, jump))
        attempt = form.reconciled(form.again(task, start, watch), watch)
        if attempt.solved and stands(attempt.task):
            return attempt
    return plain_attempt(form, priced) if all_right else None


def _all_of(task: Task) -> Task:
    """A task of which all of its jump is done, whatever was asked before."""
    return replace(task, requested=None, penalty=0.0)


def plain_attempt(form: Formulation, priced: Attempt) -> Attempt:
    """A solution in which less is done as one of all of that jump."""
    solution = replace(priced.solution, **vars(form.whole(priced.task, priced.solution)))
    return replace(priced, task=_all_of(priced.task), solution=solution)


def attempt_at_request(form: Formulation, priced: Attempt) -> Attempt:
    """A solution as one of what was asked: it is that where nothing is given up."""
    requested, plain = priced.task.requested, plain_attempt(form, priced)
    if requested is None or _falls_short(priced):
        return plain
    return form.judged(_all_of(retargeted(priced.task, requested)), plain.solution)


def _falls_short(priced: Attempt) -> bool:
    """Whether a solution's jump does less than was asked."""
    return distance(priced.task, priced.task.jump) > LEAST_SHORTFALL


def stands(task: Task) -> bool:
    """Whether all feet land on something."""
    try:
        check_footing(task)
    except NoFooting:
        return False
    return True


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
