"""Why a jump cannot be planned: the limits at which the nearest one stops, by their multipliers.

At the nearest jump multipliers say by how much less of the request would have to be given up if a
limit was a little looser: their order is right, amounts are off by up to 2.4 times. How much looser
the first one has to be is found by solving at a price under it, until nothing is given up.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from llsrbm.arrays import Array
from llsrbm.errors import NotConverged, Stop
from llsrbm.motion.plan import Plan
from llsrbm.planning.answer.nearest import LEAST_SHORTFALL, NEARER_DEARER, Nearest
from llsrbm.planning.problem.constraints import CONSTRAINTS, Constraint
from llsrbm.planning.problem.jump_horizon import row_bounds, row_places
from llsrbm.planning.problem.limits import Limit, limits_in
from llsrbm.planning.problem.placement import describe
from llsrbm.planning.problem.shortfall import distance
from llsrbm.planning.problem.task import Task
from llsrbm.planning.problem.violations import (
    describe_worst,
    phase_name,
    severity,
    stop,
    stops,
    violation_with,
    with_demand,
)
from llsrbm.planning.solve.formulation import Attempt
from llsrbm.planning.solve.watch import Watch
from llsrbm.request.jump import not_feasible

# Of a limit, or of its unit where it is next to nothing: the step with which gains are measured.
STEP, LEAST = 0.01, 0.01
# A gain below this share of the largest is none.
FEW = 0.1
# How loose a limit has to be: times as much as multipliers say, and after that times as much as the
# try before says. It is given up after so many, or where one regains less than this share.
FIRST_TRY, NEXT_TRY, MAX_TRIES, REGAINED = 1.8, 1.6, 3, 0.3
NAMED = 2  # limits at most
# Severity from which on a motion is where a solver got lost, 90 rad/s or 300 Nm beyond a limit: its
# numbers say nothing of the robot.
LOST = 30.0
ASTRAY = "the solver ended far from any motion, and no limit can be named"


@dataclass(frozen=True, eq=False)
class Gain:
    """Worth of a limit at the nearest jump.

    Attributes:
        constraint, limit, value: what is limited, and by how much.
        slope: shares of the ranges regained per unit by which the limit is looser.
    """

    constraint: Constraint
    limit: Limit
    value: float
    slope: float

    @property
    def looser(self) -> int:
        """The sign of a change that allows more."""
        return -1 if self.limit.lower_bound else 1

    @property
    def relative(self) -> float:
        """Shares regained when the limit is looser by all of itself."""
        return self.slope * max(abs(self.value), LEAST)


def refusal(
    nearest: Nearest, task: Task, last: Plan, less: Plan, explains: bool, watch: Watch
) -> NotConverged:
    """The error of a request of which less can be planned.

    Args:
        nearest, less: the nearest jump, and its plan.
        task, last: the request, and where its planning ended.
        explains: whether what it would need is found out.
        watch: reports and cancels.

    Raises:
        Cancelled: it is not wanted any more.
    """
    found = stops_of(nearest, watch) if explains else stops_at(nearest)
    reason = sentence(found)
    message = not_feasible(reason, task.jump, less.jump)
    return NotConverged(message, last, found, less, reason)


def unexplained(task: Task, best: Attempt, plan: Plan) -> NotConverged:
    """The error of a request of which no less is known: what its best attempt violates."""
    count = plan.report.attempts
    tries = f"{count} attempt{'s' * (count != 1)} ({describe(task.jump)})"
    if not best.converged and max(map(severity, best.violations.values()), default=0.0) > LOST:
        return NotConverged(f"no plan found in {tries}: {ASTRAY}", plan, reason=ASTRAY)
    found, worst = stops(best.knots), describe_worst(best.violations, best.knots)
    reason = " and ".join(map(str, found[:NAMED]))
    return NotConverged(f"no plan found in {tries}: {worst}", plan, found, reason=reason)


def gains(nearest: Nearest) -> list[Gain]:
    """Gains of the limits that hold the nearest jump back, the most important first."""
    form, priced = nearest.formulation, nearest.priced
    task, multipliers = replace(priced.task, agreed_bounds={}), priced.solution.multipliers
    lower, upper = row_bounds(form.layout, task)
    problem = form.problem(task)
    variables = priced.solution.variables
    rows = form.constraint_values(variables, problem.parameters)
    places, _ = row_places(form.layout, task)
    held = {c for c in CONSTRAINTS if np.abs(multipliers[places.get(c, [])]).max(initial=0.0) > 0}
    limits = limits_in(task)
    found = []
    for constraint in CONSTRAINTS:
        if not held & {constraint, *_limited_too(constraint)}:
            continue
        for limit, value in (limits[x.name] for x in constraint.limits if x.name in limits):
            if limit.states:
                continue
            step = STEP * max(abs(value), LEAST) * (-1 if limit.lower_bound else 1)
            other = limit.put(task, value + step)
            low, high = row_bounds(form.layout, other)
            other_rows = form.constraint_values(variables, form.problem(other).parameters)
            cost = multipliers @ (other_rows - rows)
            cost -= np.maximum(multipliers, 0.0) @ _change(upper, high)
            cost -= np.minimum(multipliers, 0.0) @ _change(lower, low)
            slope = -float(cost) / task.penalty / abs(step)
            found.append(Gain(constraint, limit, value, slope))
    found.sort(key=lambda gain: -gain.relative)
    return [gain for gain in found if gain.relative > FEW * max(found[0].relative, 0.0)]


def _change(one: Array, other: Array) -> Array:
    """Change of bounds; 0 where there is none."""
    bounded = np.isfinite(one)
    return np.subtract(other, one, out=np.zeros_like(one), where=bounded)


def stops_at(nearest: Nearest) -> tuple[Stop, ...]:
    """Where the nearest jump is at its limits, without what the request would need."""
    return tuple(_at_limit(nearest, gain) for gain in gains(nearest))


def stops_of(nearest: Nearest, watch: Watch) -> tuple[Stop, ...]:
    """The limits that stop a request, the most important first, with what it would need.

    The first of them that alone does is alone; where none does the first two are together. Raises
    `Cancelled`: it is not wanted any more.
    """
    ranked = gains(nearest)
    for gain in ranked[:NAMED]:
        found = _needed(nearest, gain, watch)
        if found is not None:
            others = (_at_limit(nearest, other) for other in ranked if other is not gain)
            return (found, *others)
    return stops_at(nearest)


def _needed(nearest: Nearest, gain: Gain, watch: Watch) -> Stop | None:
    """The value that a request needs of one limit; None: more of it alone does not do.

    It is what the rows need: where the whole body objects to that motion nothing is solved again.
    """
    value, missing = gain.value, _missing(nearest.priced)
    step = gain.looser * FIRST_TRY * missing / max(gain.slope, 1e-9)
    for _ in range(MAX_TRIES):
        end = gain.limit.loosest
        step = math.copysign(min(abs(step), abs(end - value)), step)
        if not step:
            return None
        value += step
        free = _free(nearest, gain, value, watch)
        if not free.converged:
            return None
        if (left := _missing(free)) < LEAST_SHORTFALL:
            return _demand(gain, value, free)
        if left > (1 - REGAINED) * missing:
            return None
        step, missing = step * NEXT_TRY * left / (missing - left), left
    return None


def _missing(priced: Attempt) -> float:
    return distance(priced.task, priced.task.jump)


def _demand(gain: Gain, value: float, free: Attempt) -> Stop:
    """The stop of a limit, with what a motion under a looser one needs beyond the robot's own."""
    knots = free.knots.under(gain.limit.put(free.task, gain.value))
    concerned = (gain.constraint, *_limited_too(gain.constraint))
    worst = max(
        (violation_with(free.knots, c, gain.limit, gain.value) for c in concerned), key=severity
    )
    found = stop(gain.constraint, gain.limit, gain.value, value, worst)
    return with_demand(found, gain.constraint.demand(knots), knots)


def _limited_too(constraint: Constraint) -> Iterator[Constraint]:
    """Others that a constraint's limits are in."""
    names = {limit.name for limit in constraint.limits}
    return (c for c in CONSTRAINTS if names & {*c.limited_by})


def _free(nearest: Nearest, gain: Gain, value: float, watch: Watch) -> Attempt:
    """The solution under a looser limit, in which less may be done at a price.

    What the whole body says of other limits at the nearest jump stays in their bounds.
    """
    form, priced = nearest.formulation, nearest.priced
    own = {gain.constraint.name, *(c.name for c in _limited_too(gain.constraint))}
    kept = {name: b for name, b in priced.task.agreed_bounds.items() if name not in own}
    task = gain.limit.put(replace(priced.task, agreed_bounds=kept), value)
    return form.solve(task, priced.solution.variables, watch, NEARER_DEARER)


def _at_limit(nearest: Nearest, gain: Gain) -> Stop:
    """A limit, and where the nearest jump leans on it most."""
    form, priced = nearest.formulation, nearest.priced
    places, owner = row_places(form.layout, priced.task)
    concerned = [c for c in (gain.constraint, *_limited_too(gain.constraint)) if c in places]
    rows = np.concatenate([places[c] for c in concerned])
    knots = priced.knots
    knot = int(owner[rows[np.argmax(np.abs(priced.solution.multipliers[rows]))]])
    found = Stop(
        constraint=gain.constraint.name,
        phase=phase_name(knots, knot),
        time=float(knots.time[knot]),
        amount=0.0,
        unit=gain.limit.unit,
        limit=gain.limit.name,
        title=gain.limit.title,
        value=gain.value,
        needed=gain.value,
    )
    need = gain.constraint.leaning(knots, knot, gain.value)
    return found if need is None else replace(found, demand=need)


def sentence(found: tuple[Stop, ...]) -> str:
    """The first limit, or the first two where it takes both, in words."""
    if not found:
        return "no single limiting constraint found"
    alone = found[0].amount > 0
    return " and ".join(str(stop) for stop in found[: 1 if alone else NAMED])
