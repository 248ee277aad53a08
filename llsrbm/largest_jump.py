"""The largest jump in one direction, everything else as requested.

Only jumps of the whole body whose certificate holds count. It begins where the robot's table of
solved jumps goes furthest, or else with the request itself. Then each next jump begins from the one
before or, where that does not lead on, from what the table says; steps are halved where neither
does. How far it gets depends on these steps: nothing proves that no larger jump exists.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from llsrbm.certificate import Finding, stated
from llsrbm.certified_nearest import NOT_FOUND
from llsrbm.certified_plan import CertifiedPlanner
from llsrbm.drafting import Drafting
from llsrbm.errors import InputError, JointNeed, NotConverged
from llsrbm.motion.plan import Plan
from llsrbm.number_text import decimal, degrees
from llsrbm.ocp.horizon import Iterate
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.task import Task
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.planning.solve.watch import Progress, Watch
from llsrbm.planning.whole_body.binding import Edge
from llsrbm.planning.whole_body.bounds import RowBounds
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.nearest import PRICE
from llsrbm.planning.whole_body.refine import Refiner
from llsrbm.request.jump import COMPONENTS, STEPS, Jump
from llsrbm.request.jump_types import load_type
from llsrbm.request.messages import look_up
from llsrbm.request.route import FURTHEST
from llsrbm.robots import load_robot
from llsrbm.robots.payload import with_payload

# Of the file's range, where the table's furthest jump is looked for.
SHARES = (1.0, 0.75, 0.5, 0.25)
NEARBY = 2  # steps that are tried at once from where a landing has been moved to
BACK = (0, 1, 3, 6)  # steps before that which are tried where its certificate does not hold
OF_INTERVALS = ("dynamics", "slip")
NO_LIMIT = "no limit of the robot stops it as far as was searched"


@dataclass(frozen=True)
class Direction:
    """A component of a jump towards one side; amounts in whole steps of `STEPS`.

    Attributes:
        field: of a `Jump`; sign: of what is more of it; unit: SI.
        first: steps at once, halved down to one; furthest: where a search ends.
    """

    field: str
    sign: int
    unit: str
    first: int
    furthest: int

    @classmethod
    def along(cls, field: str, sign: int) -> Direction:
        """A component's towards one side, as far as may be asked for."""
        furthest = math.floor(FURTHEST[field] / STEPS[field] + 1e-6)
        if field == "twist":
            return cls(field, sign, "rad", 10, furthest)
        return cls(field, sign, "m", 5, furthest)

    def of(self, jump: Jump, steps: int) -> Jump:
        """The jump with so many steps of it."""
        changed: dict[str, Any] = {self.field: self.sign * self.value(steps)}
        return replace(jump, **changed)

    def value(self, steps: int) -> float:
        """So many steps, rad or m."""
        return round(steps * STEPS[self.field], 9)

    def steps(self, amount: float) -> int:
        """Whole steps in an amount of the field; none of one towards the other side."""
        return max(0, math.floor(self.sign * amount / STEPS[self.field] + 1e-6))

    def in_words(self, value: float) -> str:
        """An amount, rad or m, for people."""
        return degrees(value, 0) if self.unit == "rad" else f"{decimal(value, 2)} m"


DIRECTIONS = {
    "twist": Direction.along("twist", 1),
    "forward": Direction.along("forward", 1),
    "backward": Direction.along("forward", -1),
    "lateral": Direction.along("lateral", 1),
    "up": Direction.along("height", 1),
    "down": Direction.along("height", -1),
    "twist-right": Direction.along("twist", -1),
    "lateral-right": Direction.along("lateral", -1),
}


@dataclass(frozen=True, eq=False)
class Largest:
    """The largest jump of one component.

    Attributes:
        component: a name of `DIRECTIONS`; value: in `unit`, "rad" or "m", of its direction.
        limit: what stops more of it, in the words of a refusal.
        plan: its plan, whose certificate holds; smaller: those on the way, in order.
    """

    component: str
    value: float
    unit: str
    limit: str
    plan: Plan
    smaller: tuple[Plan, ...] = ()


@dataclass(frozen=True, eq=False)
class Reached:
    """A jump that is planned: its steps, its plan, and its solution with the problem's rows."""

    steps: int
    plan: Plan
    solution: Iterate
    rows: RowBounds


@dataclass(frozen=True)
class Missed:
    """A jump that is not; why: "" where no check of a certificate says it.

    `found`: a motion of it is, whose certificate does not hold.
    """

    why: str = ""
    found: bool = False


@dataclass(frozen=True)
class Search:
    """The search of one request.

    Attributes:
        jump: the request; direction: what grows of it.
        drafting: weights and limits; where it is not begun from a table, how its draft is made.
    """

    jump: Jump
    direction: Direction
    drafting: Drafting

    def run(self) -> tuple[list[Reached], str]:
        """Ever larger jumps, and what stops more. Raises `NotConverged`: not one is planned."""
        way, missed, step = [self._begun()], Missed(), self.direction.first
        if (further := self._moved(way[-1])) is not None:
            way.append(further)
            step = NEARBY
        while step and way[-1].steps < self.direction.furthest:
            most = min(way[-1].steps + step, self.direction.furthest)
            found = self._tried(most, way[-1])
            if isinstance(found, Reached):
                way.append(found)
            else:
                step, missed = step // 2, found
        if step:
            return way, NO_LIMIT
        before = way[0].solution if len(way) > 1 else None
        stop = None if missed.why else Edge(way[-1].rows, way[-1].solution, before).stop()
        return way, missed.why or (NO_LIMIT if stop is None else str(stop))

    def _begun(self) -> Reached:
        """The furthest of the table's jumps, or the request's own plan."""
        direction = self.direction
        own = direction.steps(getattr(self.jump, direction.field))
        low, high = getattr(self._task(own).robot.file.task, direction.field)
        end = direction.steps(high if direction.sign > 0 else low)
        for steps in dict.fromkeys([*(math.floor(share * end) for share in SHARES), own]):
            found = self._tried(steps) if steps >= own else None
            if isinstance(found, Reached):
                return found
        return self._from_draft(own)

    def _from_draft(self, steps: int) -> Reached:
        jump, of = self.direction.of(self.jump, steps), self.drafting
        draft = of.draft(jump, load_robot(jump.robot))
        found = self._refiner.refine(draft, cancelled=of.cancelled, progress=of.progress)
        reached = self._judged(steps, found, of.progress)
        if isinstance(reached, Missed):
            why = reached.why or NOT_FOUND
            raise NotConverged(f"no jump to begin from: {why}", found, reason=why)
        return reached

    def _moved(self, best: Reached) -> Reached | None:
        """The furthest that its landing can be moved to at once; None: not from there."""
        direction, at = self.direction, self._task(best.steps)
        if at.schedule.places > 1:  # what lies between goes with the landing
            return None
        wanted = np.zeros(len(COMPONENTS))
        left = direction.value(direction.furthest) - direction.value(best.steps)
        wanted[COMPONENTS.index(direction.field)] = direction.sign * left
        progress = self._saying(direction.furthest, best)
        watch = Watch(self.drafting.cancelled, progress)
        moved = self._refiner.moved(at, best.solution, wanted, PRICE, watch)
        if moved is None:
            return None
        offset = moved.offset[COMPONENTS.index(direction.field)]
        reached = getattr(at.jump, direction.field) + float(offset)
        for back in BACK:
            steps = direction.steps(reached) - back
            if steps <= best.steps:
                break
            plan = self._refiner.beside(self._task(steps), moved.solution, watch, straighter=True)
            found = self._judged(steps, plan, progress)
            if isinstance(found, Reached):
                return found
        return None

    def _tried(self, steps: int, best: Reached | None = None) -> Reached | Missed:
        """A jump, begun from the largest that is planned, or from the table's."""
        try:
            task = self._task(steps)
        except InputError as error:  # a foot would have no place to stand
            return Missed(str(error))
        progress = self._saying(steps, best)
        for nearby in self._starts(task, best):
            watch = Watch(self.drafting.cancelled, progress)
            found = self._judged(steps, self._refiner.beside(task, nearby, watch), progress)
            # From elsewhere mostly the same motion is found.
            if isinstance(found, Reached) or found.found:
                return found
        return Missed()

    def _starts(self, task: Task, best: Reached | None) -> Iterator[Iterate]:
        if best is not None:
            yield best.solution
        nearby = self._refiner.nearby(task.jump, task.tuning)
        if nearby is not None:
            yield nearby

    def _saying(self, steps: int, best: Reached | None) -> Progress | None:
        """Progress that says how far it has come, whatever is done for it."""
        progress, words = self.drafting.progress, self.direction.in_words
        if progress is None:
            return None
        line = f"trying {words(self.direction.value(steps))}"
        if best is not None:
            line = f"{words(self.direction.value(best.steps))} holds, {line}"
        return lambda step: progress(replace(step, text=line))

    def _judged(self, steps: int, plan: Plan, progress: Progress | None) -> Reached | Missed:
        if not plan.refined:
            return Missed()
        solution, rows = self._refiner.solution, self._refiner.rows
        assert solution is not None
        assert rows is not None
        held = CertifiedPlanner(cancelled=self.drafting.cancelled, progress=progress).held(plan)
        if held.certified:
            return Reached(steps, held, solution, rows)
        return Missed(_not_held(held), found=True)

    def _task(self, steps: int) -> Task:
        jump, of = self.direction.of(self.jump, steps), self.drafting
        robot = with_payload(load_robot(jump.robot), jump.payload)
        return make_task(jump, robot, of.weights, of.limits)

    @cached_property
    def _refiner(self) -> Refiner:
        task = self._task(self.direction.steps(getattr(self.jump, self.direction.field)))
        counts = layout_of(task.jump, task.robot, self.drafting.intervals).intervals
        watch = Watch(self.drafting.cancelled, self.drafting.progress)
        watch.wait()
        return watch.built(partial(Refiner, task.robot, Grid.at(task.schedule, counts)))


def largest_jump(jump: Jump, component: str, drafting: Drafting) -> Largest:
    """The largest jump of a component. Raises as `llsrbm.largest`."""
    direction = look_up("component", component, DIRECTIONS)
    if jump.turns:
        raise InputError(
            "the largest jump is looked for among plans of the whole body, which are not made of "
            "jumps that turn over; expected no roll and no pitch"
        )
    if jump.route:
        raise InputError(
            "route: its landings alone say where the jumps lead; expected a request without a route"
        )
    if direction.field == "forward" and load_type(jump.type).passes:
        raise InputError(
            f"{component}: jumps of type {jump.type} lead as far as what they pass over asks; "
            "expected another component"
        )
    way, limit = Search(jump, direction, drafting).run()
    *smaller, plan = (each.plan for each in way)
    value = direction.value(way[-1].steps)
    return Largest(component, value, direction.unit, limit, plan, tuple(smaller))


def _not_held(plan: Plan) -> str:
    """The first check of a certificate that does not hold, in words; "" where the robot has no part
    in it: what the equations of motion miss between nodes is of the intervals, and with them feet
    slip there.
    """
    found = stated(plan)
    broken = [each for each in found.broken if each.name not in OF_INTERVALS] if found else []
    return _in_words(broken[0]) if broken else ""


def _in_words(finding: Finding) -> str:
    at = f"at {finding.time_s or 0.0:.2f} s"
    worst, limit = finding.worst or 0.0, finding.limit
    if finding.name.startswith(("joint_speed", "joint_torque", "torque_at_speed")) and limit:
        return str(JointNeed(finding.where, worst * limit, limit, finding.unit, at))
    what = finding.name.replace("_", " ")
    allowed = "" if finding.allowed is None else f", allowed is {finding.shown(finding.allowed)}"
    return f"{what} of {finding.where} is {finding.shown(worst)} {at}{allowed}"
