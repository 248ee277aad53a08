"""An answer for a slider that moves: the first jump that is found near a request, as it is.

The nearest one, in whole steps and with its reasons, is looked for once the slider rests
(`answer.nearest`), which takes twice the time or more.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from llsrbm.arrays import Array
from llsrbm.ocp import solvers
from llsrbm.ocp.horizon import Iterate
from llsrbm.planning.answer.nearby import NEARBY_MISS
from llsrbm.planning.answer.nearest import (
    Nearest,
    attempt_at_request,
    plain_attempt,
    stands,
    starts,
)
from llsrbm.planning.problem.placement import retargeted
from llsrbm.planning.problem.task import Task
from llsrbm.planning.solve.formulation import NEARER_AGAIN, Attempt, Formulation
from llsrbm.planning.solve.watch import Watch
from llsrbm.request.jump import Jump

# From a plan nearby, as `nearby.NEARBY_MISS` has it: 9 to 25 iterations.
FROM_NEARBY = replace(solvers.FROM_GUESS, mu=1e-4, push=1e-3, iterations=50)
# Times that the whole body is asked about a whole turn: where its feet roll to, and with them its
# legs' momentum, depends on the answer before.
MAX_SHIFTS_TURNING = 3
MAX_TRIES = 3  # solutions, each with what the whole body says of the one before; most need one


def with_bounds_nearby(
    formulation: Formulation,
    task: Task,
    jump: Jump,
    solution: Iterate,
    known: Iterable[Attempt] = (),
) -> Task:
    """A task, with what the whole body says of the solution of a jump nearby in its bounds.

    Where that one meets a limit, so will this: without it every step of a slider would be solved,
    checked and solved again. `known`: attempts, one of which may have that solution.
    """
    shifted = retargeted(task, jump)
    if jump.turns:
        known = ()  # where its feet are depends on the task, too
    for _ in range(MAX_SHIFTS_TURNING if jump.turns else 1):
        shifted = formulation.with_bounds_of_start(shifted, solution, known)
    return replace(
        task,
        agreed_bounds=shifted.agreed_bounds,
        correction=shifted.correction,
        rolled=shifted.rolled,
    )


def first_feasible(
    form: Formulation, task: Task, begun: tuple[Jump, Array], watch: Watch
) -> Nearest | None:
    """A jump near a task's, often the request itself; None: none was found in a hurry.

    Args:
        form: of such jumps.
        task: the request's.
        begun: the jump of a solution nearby, and all its variables, or those of where solving
            the request was given up.
        watch: reports and cancels.

    Raises:
        Cancelled: it is not wanted any more.
    """
    for start, options, at_price in starts(form, task, begun):
        close = form.solver.miss(form.problem(at_price), start) < NEARBY_MISS
        priced = form.solve(at_price, start, watch, FROM_NEARBY if close else options)
        if priced.converged:
            return _first_that_stands(form, priced, watch)
    return None


def _first_that_stands(form: Formulation, priced: Attempt, watch: Watch) -> Nearest | None:
    for _ in range(MAX_TRIES):
        for plain in (attempt_at_request(form, priced), plain_attempt(form, priced)):
            if plain.solved and stands(plain.task):
                return Nearest(plain, priced, form)
        shifted = form.with_shifted_bounds(priced)
        priced = form.solve(shifted, priced.solution.variables, watch, NEARER_AGAIN)
        if not priced.converged:
            break
    return None
