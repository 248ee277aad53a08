"""The nearest jump that can be planned: less of one component of the request, or of all alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from llsrbm.errors import Error, NoFooting
from llsrbm.motion.plan import Plan
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.solve.explanation import explain, in_words
from llsrbm.planning.solve.formulation import Attempt
from llsrbm.planning.solve.planner import Planner
from llsrbm.planning.solve.progress import PlanningProgress, Watch
from llsrbm.planning.solve.search import FeasibilitySearch
from llsrbm.request.jump import Jump
from llsrbm.robots.schema import Task as Ranges

# rad and m; results are whole steps of the components that were reduced.
STEPS = {
    "twist": math.radians(1.0),
    "forward": 0.01,
    "lateral": 0.01,
    "height": 0.01,
}

# Where the next try is made between what works, 0, and what does not, 1: nearer to what works, as
# a failure takes longer than a success.
CAUTION = 0.4


@dataclass(frozen=True, eq=False)
class Nearest:
    """The nearest jump that can be planned.

    Attributes:
        jump: what can be planned; plan: its plan.
        changes: how it differs from the request, in words; "" if it does not.
    """

    jump: Jump
    plan: Plan
    changes: str


@dataclass(frozen=True)
class Way:
    """One way to ask for less: some components reduced alike, the others kept.

    Attributes:
        jump: the request, within the robot's range.
        reduced: names of the components.
    """

    jump: Jump
    reduced: tuple[str, ...]

    @property
    def steps(self) -> int:
        """Number of steps of the largest of them."""
        return max(math.ceil(_steps(self.jump, name) - 1e-6) for name in self.reduced)

    def at(self, step: int) -> Jump:
        """The jump at a step: 0, nothing of the components; `steps`, all."""
        if step >= self.steps:
            return self.jump
        share = step / self.steps
        less = {}
        for name in self.reduced:
            whole = math.floor(share * _steps(self.jump, name) + 1e-6)
            less[name] = math.copysign(whole * STEPS[name], getattr(self.jump, name)) + 0.0
        return _with(self.jump, less)


def find_nearest(
    planner: Planner,
    jump: Jump,
    *,
    weights: Mapping[str, float] | None = None,
    limits: Mapping[str, float] | None = None,
    progress: Callable[[str], None] | None = None,
    cancelled: Callable[[], bool] | None = None,
) -> Nearest:
    """Find the nearest jump that can be planned, its distance in shares of the robot's ranges.

    Components of the request beyond the robot's range are taken back to it first. Then each
    component alone is reduced, and all alike, as little as does; the smallest change wins.

    Raises:
        InputError: an unknown weight or limit.
        Error: not even a jump on the spot can be planned; says which limits would have to change.
        Cancelled: `cancelled` was true.

    Args:
        planner: of the jump's robot and model.
        jump: the request.
        weights, limits: as in `llsrbm.plan`.
        progress: called with each try, in words.
        cancelled: called before and during every solve; true to stop.
    """
    robot = planner.formulation.robot
    ranges = robot.file.task
    within = _within(jump, ranges)
    on_the_spot = replace(jump, twist=0.0, forward=0.0, lateral=0.0, height=0.0)

    def report(step: PlanningProgress) -> None:
        if progress is not None and step.iteration is None:
            progress(step.text)

    search = FeasibilitySearch(planner.formulation, Watch(cancelled, progress and report))
    tried = _Reductions(search, lambda other: _distance(other, within, ranges), weights, limits)
    if tried.found(on_the_spot) is None:
        search.about = "what stops a jump on the spot"
        stops = explain(search, make_task(on_the_spot, robot, weights, limits))
        raise Error(f"not even a jump on the spot can be planned: {in_words(stops)}")
    components = tuple(name for name in STEPS if getattr(within, name) != 0)
    ways = [(name,) for name in components] if len(components) > 1 else []
    for reduced in [components, *ways] if components else []:
        tried.along(Way(within, reduced))
    best = tried.best
    return Nearest(best.task.jump, search.plan(best), _changes(jump, best.task.jump))


class _Reductions:
    """Looks along one way after another, no further than could still be nearer."""

    def __init__(
        self,
        search: FeasibilitySearch,
        distance: Callable[[Jump], float],
        weights: Mapping[str, float] | None,
        limits: Mapping[str, float] | None,
    ) -> None:
        self.search = search
        self._distance = distance
        self._weights, self._limits = weights, limits
        self._known: list[Attempt] = []

    @property
    def best(self) -> Attempt:
        """The nearest so far."""
        return min(self._known, key=lambda found: self._distance(found.task.jump))

    def found(self, jump: Jump) -> Attempt | None:
        """A jump's solution from the nearest that is known."""
        known = next((found for found in self._known if found.task.jump == jump), None)
        if known is not None:
            return known
        self.search.about = f"looking for a jump that works: {_in_words(jump)}"
        try:
            task = make_task(jump, self.search.formulation.robot, self._weights, self._limits)
        except NoFooting:
            return None
        ranges = self.search.formulation.robot.file.task
        near = min(
            self._known,
            key=lambda found: _distance(found.task.jump, jump, ranges),
            default=None,
        )
        found = self.search.solve(task, near)
        if found is not None:
            self._known.append(found)
        return found

    def along(self, way: Way) -> None:
        """Find the furthest step of a way that works, if it is nearer than what is known."""
        nearest = self._distance(self.best.task.jump)
        nearer = (n for n in range(way.steps + 1) if self._distance(way.at(n)) < nearest)
        works = next(nearer, None)
        if works is None:
            return
        if way.at(0) in [found.task.jump for found in self._known]:
            works = 0
        elif self.found(way.at(works)) is None:
            return
        if self.found(way.at(way.steps)) is not None:
            return
        fails = way.steps
        while fails - works > 1:
            step = works + max(1, round(CAUTION * (fails - works)))
            if self.found(way.at(step)) is None:
                fails = step
            else:
                works = step


def _within(jump: Jump, ranges: Ranges) -> Jump:
    clamped = {
        name: min(max(getattr(jump, name), low), high) for name, (low, high) in _ends(ranges)
    }
    return _with(jump, clamped)


def _with(jump: Jump, components: Mapping[str, float]) -> Jump:
    changed: dict[str, Any] = dict(components)
    return replace(jump, **changed)


def _ends(ranges: Ranges) -> list[tuple[str, tuple[float, float]]]:
    return [(name, getattr(ranges, name)) for name in STEPS]


def _distance(one: Jump, other: Jump, ranges: Ranges) -> float:
    """Distance of two requests, each component as a share of the robot's range."""
    shares = (
        (getattr(one, name) - getattr(other, name)) / ((high - low) or 1.0)
        for name, (low, high) in _ends(ranges)
    )
    return math.hypot(*shares)


def _steps(jump: Jump, name: str) -> float:
    return abs(getattr(jump, name)) / STEPS[name]


def _value(jump: Jump, name: str) -> str:
    value = getattr(jump, name)
    return f"{math.degrees(value):.4g} deg" if name == "twist" else f"{value:.3g} m"


def _in_words(jump: Jump) -> str:
    moved = [f"{name} {_value(jump, name)}" for name in STEPS if getattr(jump, name) != 0]
    return ", ".join(moved) or "on the spot"


def _changes(request: Jump, found: Jump) -> str:
    """The differences, in words; values that look alike are none."""
    values = ((name, _value(found, name), _value(request, name)) for name in STEPS)
    return ", ".join(f"{name} {new} instead of {old}" for name, new, old in values if new != old)
