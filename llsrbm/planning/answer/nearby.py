"""The way to a jump's solution other than from the analytic guess: from others nearby."""

from __future__ import annotations

from dataclasses import replace

from llsrbm.errors import UnusableStart
from llsrbm.motion.plan import Plan
from llsrbm.ocp.horizon import Iterate
from llsrbm.planning.problem.task import Task
from llsrbm.planning.solve.formulation import (
    FROM_CLOSE,
    Attempt,
    Formulation,
    best_of,
)
from llsrbm.planning.solve.watch import Watch

# Between solutions that violate no row by more than this 94 % of Go2's jumps (85 % of SLIDER's) are
# solved by following, in 4 iterations at the median; of the others every second one, in more.
NEARBY_MISS = 0.1
# The others: SLIDER's jumps take 13 iterations so, 16 with the first patience, and 18 from the
# analytic guess.
FROM_NEARBY_SLOWLY = replace(FROM_CLOSE, iterations=30)


def usable_start(near: Plan, formulation: Formulation) -> Iterate:
    """A plan's solution, from which the next one starts. Raises `UnusableStart`: it is not of this
    robot, model and version of the planner.
    """
    robot, model, layout = formulation.robot, formulation.model, formulation.layout
    knots, of = len(near.time), near.jump
    # A refined plan has knots of its own; its solution is of the first stage, and of its size.
    fits = near.refined or knots == layout.knots
    if of.model != model.name or not fits or near.robot_parameters != robot.parameters():
        raise UnusableStart(
            f"near: a plan of {of.robot} with {of.model} and {knots - 1} intervals cannot be "
            f"started from; expected {robot.name} as it is now with {model.name} "
            f"and {layout.knots - 1} intervals"
        )
    solution = near.solution
    if solution is None:
        raise UnusableStart(
            "near: a plan that did not converge, or whose file was written before files held "
            "what that takes, cannot be started from; expected one that converged"
        )
    sizes = len(solution.variables), len(solution.multipliers)
    expected = formulation.solver.sizes
    if sizes != expected:
        raise UnusableStart(
            f"near: the plan is of another version of the planner: {sizes[0]} variables and "
            f"{sizes[1]} constraints; expected {expected[0]} and {expected[1]}"
        )
    return solution


def from_nearby(formulation: Formulation, start: Iterate, task: Task, watch: Watch) -> Attempt:
    """Follow from near; from further off, and where following creeps, solve from there."""
    attempts: list[Attempt] = []
    if formulation.solver.miss(formulation.problem(task), start.variables) < NEARBY_MISS:
        attempts.append(formulation.follow(task, start, watch))
    if not attempts or not attempts[-1].solved:
        attempts.append(formulation.solve(task, start.variables, watch, FROM_NEARBY_SLOWLY))
    return best_of(attempts)
