"""The limit that makes a jump impossible: the one whose change alone makes it feasible.

What a failed solve violates most is often a law of motion that it could not mend, not the limit
that made it fail. So limits are relaxed, one at a time, until the jump can be planned, and then
tightened again towards their value as far as that goes.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from dataclasses import dataclass, replace

from llsrbm.errors import NotConverged, Stop
from llsrbm.motion.plan import Violation
from llsrbm.planning.problem.constraints import CONSTRAINTS, Constraint
from llsrbm.planning.problem.limits import Limit, limits_in, put_limits
from llsrbm.planning.problem.placement import place_task
from llsrbm.planning.problem.task import Task
from llsrbm.planning.problem.violations import (
    TOLERANCE,
    severity,
    stop,
    violation_with,
    with_demand,
)
from llsrbm.planning.solve.formulation import Attempt
from llsrbm.planning.solve.search import FeasibilitySearch, OutOfTime

# A limit that would have to change is found to this share of the change that is known to do.
RESOLUTION = 1 / 16
# s; a person waits for the answer, and what the last iterate violates is one too.
EXPLANATION_TIME = 20.0
# Limits tried one at a time when none was changed by the request: those exceeded most.
TRIED = 5
# Tried before the others: a jump that stronger drives would do is beyond the robot's drives.
DRIVE_LIMITS = ("torque_share", "speed_share")


@dataclass(frozen=True)
class _Suspect:
    """A limit, its value, and a looser one that is tried."""

    constraint: Constraint
    limit: Limit
    value: float
    looser: float

    def at(self, share: float) -> float:
        """Between the value, 0, and the looser one, 1."""
        return self.value + share * (self.looser - self.value)


def explain(search: FeasibilitySearch, task: Task) -> tuple[Stop, ...]:
    """The limits each of which alone, changed as said, makes a jump plannable; easiest first.

    Limits that the request tightens are relaxed to the robot's own; if that does not do, or there
    are none, those of the drives to the end of their range; then every limit. Where no limit alone
    does, those that have to be changed together are named. Empty: even all of them do not do.
    """
    own = place_task(task.jump, search.formulation.robot)
    tightened = [s for s in _suspects(task, own) if s.limit.name in task.tuning.limits]
    every = _suspects(task, None)
    drives = [s for s in every if s.limit.name in DRIVE_LIMITS]
    for suspects in (tightened, drives, every):
        if not suspects:
            continue
        free = search.solve(_with(task, suspects, 1.0))
        if free is None:
            continue
        if len(suspects) > 1 and suspects is every:
            suspects, free = _exceeded(search, task, suspects, free)
        alone = [(s, f) for s in suspects if (f := search.solve(_with(task, [s], 1.0), free))]
        if not alone and len(suspects) > 1:
            share, free = _march(search, task, suspects, free)
            stops = _by_ease(replace(_stop(s, share, free), together=True) for s in suspects)
            return tuple(sorted(stops, key=lambda s: not s.detail))  # the drives' first
        return _by_ease(_tightened(search, task, s, f) for s, f in alone)
    return ()


def explained(search: FeasibilitySearch, error: NotConverged, task: Task) -> NotConverged:
    """The planner's failure with what really stops it, where that is found."""
    search.about = "looking for the limit that stops it"
    search.deadline = time.monotonic() + EXPLANATION_TIME
    try:
        stops = explain(search, task)
    except OutOfTime:
        stops = ()
    search.deadline = math.inf
    if not stops:
        return error
    attempts = error.plan.report.attempts
    message = f"no plan found in {attempts} attempts: {in_words(stops)}"
    return NotConverged(message, error.plan, stops)


def _suspects(task: Task, own: Task | None) -> list[_Suspect]:
    """Limits that can be looser: as in `own`, or at the end of their range."""
    robots = limits_in(own or task)
    found = []
    for constraint in CONSTRAINTS:
        for limit, _ in (robots[x.name] for x in constraint.limits if x.name in robots):
            value = limit.of(task)
            looser = limit.of(own) if own is not None else limit.loosest
            if (value > looser) if limit.lower_bound else (value < looser):
                found.append(_Suspect(constraint, limit, value, looser))
    return found


def _with(task: Task, suspects: Iterable[_Suspect], share: float) -> Task:
    return put_limits(task, {s.limit.name: s.at(share) for s in suspects})


def _exceeded(
    search: FeasibilitySearch, task: Task, suspects: list[_Suspect], free: Attempt
) -> tuple[list[_Suspect], Attempt]:
    """Those that a plan still needs when all are relaxed as little as can be, the most first."""
    _, free = _march(search, task, suspects, free)
    sizes = {s: severity(_worst(s, free)) for s in suspects}
    needed = [s for s, size in sizes.items() if size > TOLERANCE]
    return sorted(needed, key=lambda s: -sizes[s])[:TRIED], free


def _march(
    search: FeasibilitySearch, task: Task, suspects: list[_Suspect], free: Attempt
) -> tuple[float, Attempt]:
    """The smallest share of the way to the looser limits that does, and the plan there."""
    enough, too_little = 1.0, 0.0
    while enough - too_little > RESOLUTION:
        # Nearer to what is known to do: a failure takes longer than a success.
        share = enough - 0.4 * (enough - too_little)
        found = search.solve(_with(task, suspects, share), free)
        if found is None:
            too_little = share
        else:
            enough, free = share, found
    return enough, free


def _tightened(search: FeasibilitySearch, task: Task, suspect: _Suspect, free: Attempt) -> Stop:
    share, free = _march(search, task, [suspect], free)
    return _stop(suspect, share, free)


def _stop(suspect: _Suspect, share: float, free: Attempt) -> Stop:
    """The excess of a plan under the looser limit over the limit."""
    constraint, limit, value = suspect.constraint, suspect.limit, suspect.value
    found = stop(constraint, limit, value, suspect.at(share), _worst(suspect, free))
    knots = free.knots.under(limit.put(free.task, value))
    return with_demand(found, constraint.demand(knots), knots)


def _worst(suspect: _Suspect, free: Attempt) -> Violation:
    """The worst violation by a plan, were the limit as it is, of all constraints it is in."""
    limit = suspect.limit
    concerned = [suspect.constraint, *(c for c in CONSTRAINTS if limit.name in c.limited_by)]
    found = [violation_with(free.knots, c, limit, suspect.value) for c in concerned]
    return max(found, key=severity)


def _by_ease(stops: Iterable[Stop]) -> tuple[Stop, ...]:
    return tuple(sorted(stops, key=lambda s: s.amount / max(abs(s.value), TOLERANCE)))


def in_words(stops: tuple[Stop, ...]) -> str:
    """The limits that would have to change, in one line."""
    if not stops:
        return "no limit is found that would do"
    return (" and " if stops[0].together else " or ").join(map(str, stops))
