"""A draft in, the whole body's plan with its certificate out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

from llsrbm.certificate import certified
from llsrbm.certificate.power import BatteryCurrent, Regeneration, WindingHeat
from llsrbm.errors import InputError, Stop
from llsrbm.motion.plan import Plan
from llsrbm.ocp.progress import interruptible
from llsrbm.planning.problem.placement import make_task, retargeted
from llsrbm.planning.problem.task import Task
from llsrbm.planning.solve.jump_layout import INTERVALS, layout_of
from llsrbm.planning.solve.watch import Progress, Watch
from llsrbm.planning.whole_body.feasible import feasible_of
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.learned_file import leads_to
from llsrbm.planning.whole_body.nearest import nearest
from llsrbm.planning.whole_body.refine import (
    planned,
    planned_through,
    refined,
    refiner_at,
    refiner_of,
    untried,
)
from llsrbm.robots import load_robot
from llsrbm.robots.robot import Robot

FINER = 2.0  # times as many intervals where a certificate does not hold
# Checks of what no row of the problem has; what fails of them does so on any grid.
WITHOUT_ROWS = (Regeneration.name, BatteryCurrent.name, WindingHeat.name)


class Nearest(NamedTuple):
    """The certified plan of the nearest jump; stop: what stops more, None: it is not known."""

    plan: Plan
    stop: Stop | None


@dataclass(frozen=True)
class CertifiedPlanner:
    """How whole bodies' plans are made.

    Attributes:
        robot: the one that plans name, with other drives; None: as it is.
        guesses: begin from jumps nearby that were solved before, where the robot has a table.
        finer: plan again with more intervals where a certificate does not hold.
        settles: wait until solvers are compiled, so that results are the same whenever they are
            computed.
        cancelled: polled; true: `Cancelled`; progress: told of each step.
    """

    robot: Robot | None = None
    guesses: bool = True
    finer: bool = True
    settles: bool = False
    cancelled: Callable[[], bool] | None = None
    progress: Progress | None = None

    def plan(self, draft: Plan) -> Plan:
        """The whole body's plan of a draft that converged, with its certificate.

        Where no plan is found it is the draft, without a certificate; its `refinement` says so.
        Raises `Cancelled`: `cancelled` was true.
        """
        return self.held(self._refined(draft, 1.0))

    def held(self, plan: Plan) -> Plan:
        """A plan with its certificate; where that does not hold, that motion with more intervals.

        The more intervals there are, the less is missed between the nodes at which rows hold.
        Raises `Cancelled`: `cancelled` was true.
        """
        found = self.checked(plan)
        if not (self.finer and found.refined and may_hold_elsewhere(found)):
            return found
        # Its solver is built first, which takes seconds.
        self._watch.begin("a check does not hold: planning again with more intervals")
        finer = self.checked(self._refined(found, FINER))
        best, other = (finer, found) if finer.certified else (found, finer)
        assert best.refinement is not None
        assert other.refinement is not None
        return replace(best, refinement=best.refinement.beside(other.refinement))

    def nearest(
        self, task: Task, intervals: int = INTERVALS, *, less: bool = True
    ) -> Nearest | None:
        """The certified plan of a task's jump, or of `less`, by moving a landing of the table's.

        None: the robot has no table of such jumps, or none is found from there. `intervals`: as for
        three phases. Raises `Cancelled`: `cancelled` was true.
        """
        if not (self.guesses and leads_to(task.jump, task.tuning)):
            return None
        robot, feasible = task.robot, feasible_of(load_robot(task.jump.robot))
        if feasible is None:
            return None
        grid = Grid.at(task.schedule, layout_of(task.jump, robot, intervals).intervals)
        watch = self._watch
        refiner = refiner_at(robot, grid, watch, settles=self.settles)
        for reached in nearest(refiner, task, feasible, watch):
            if not less and reached.jump != task.jump:
                return None
            try:
                at = make_task(reached.jump, task.robot, task.tuning.weights, task.tuning.limits)
            except InputError:  # a leg does not reach its stone there
                continue
            found = self.held(refiner.beside(at, reached.solution, watch, straighter=True))
            if found.certified:
                return Nearest(found, None if reached.edge is None else reached.edge.stop())
        return None

    def from_table(self, task: Task, intervals: int = INTERVALS) -> Plan | None:
        """The certified plan of a task, begun from the robot's table; None: not found from there.

        `intervals`: as for three phases. Raises `Cancelled`: `cancelled` was true.
        """
        if not self.guesses:
            return None
        begun = self._begun(task, intervals)
        found = begun and self.held(begun)
        return found if found is not None and found.certified else None

    def _begun(self, task: Task, intervals: int) -> Plan | None:
        """The plan of a task that the robot's table leads to, without a certificate."""
        counts = layout_of(task.jump, task.robot, intervals).intervals
        if _lands_and_goes_on(task):
            return self._through(task, counts)
        return planned(
            *(task, counts),
            settles=self.settles,
            cancelled=self.cancelled,
            progress=self.progress,
        )

    def _through(self, task: Task, counts: Sequence[int]) -> Plan | None:
        """The plan of several jumps in a row, begun from the table's plans of each by itself.

        These are where it begins: what of their certificates does not hold is no matter yet.
        """
        parts = []
        for jump in task.jump.singly(task.displacement or [None] * task.schedule.places):
            part = self._begun(retargeted(task, jump), INTERVALS)
            if part is None:
                return None
            parts.append(part)
        return planned_through(
            *(task, counts, parts),
            settles=self.settles,
            cancelled=self.cancelled,
            progress=self.progress,
        )

    def checked(self, plan: Plan) -> Plan:
        """A plan with its certificate; a draft as it is."""
        if not plan.refined:
            return plan
        self._watch.begin("checking the motion at 1 kHz")
        return interruptible(partial(certified, plan, self.robot), self.cancelled)

    @property
    def _watch(self) -> Watch:
        return Watch(self.cancelled, self.progress)

    def _refined(self, draft: Plan, finer: float) -> Plan:
        if self.settles and not untried(draft):
            refiner_of(draft, self.robot, finer).solver.settle()
        return refined(
            draft,
            self.robot,
            # A table's jumps are on the first grid.
            learned=self.guesses and finer == 1.0,
            finer=finer,
            cancelled=self.cancelled,
            progress=self.progress,
        )


def _lands_and_goes_on(task: Task) -> bool:
    """Whether it is several jumps in a row, each from all feet to all feet, from rest to rest."""
    jump, together = (
        task.jump,
        all(len(p.feet) in (0, len(task.schedule.legs)) for p in task.schedule),
    )
    still = not (jump.turns or jump.speed or jump.end_speed)
    return task.schedule.places > 1 and together and still


def may_hold_elsewhere(plan: Plan) -> bool:
    """Whether what failed has rows, which more nodes or less of a jump may hold."""
    if not plan.refined:
        return not plan.jump.turns
    return any(
        finding["holds"] is False and name not in WITHOUT_ROWS
        for name, finding in (plan.certificate or {}).items()
    )
