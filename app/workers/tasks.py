"""Tasks: work that the server gives to its computing processes, which answer with reports.

A task states itself what the pool has to know of it, and how a process works on it: another kind of
task is a class here and a method of the planner (`app.workers.worker`).

Every job has a number of its own, and a process works on one job at a time, so "stop job n" is
unambiguous and needs no reset.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, ClassVar

from app.workers.opened_file import States
from app.workers.reports import (
    Checked,
    Exported,
    FoundLargest,
    Opened,
    Outcome,
    Planned,
    Prepared,
    Refused,
    Repaired,
    Simulated,
    Talk,
)
from llsrbm.errors import NotConverged
from llsrbm.formats import find
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.planning.problem.apex import limits_apex
from llsrbm.request.design import SUFFIX
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning

READING_LIMIT = 60.0
"""Time (s) that the reading of a file may take; the largest that is accepted takes a few."""

_NUMBERS = {".npz", ".csv", ".json", ".pkl", SUFFIX}  # of files that hold nothing else


class Kind(Enum):
    """Kinds of jobs; a tab has one of each running at a time."""

    PLAN = "plan"
    REFINE = "refine"
    REPAIR = "repair"
    SIMULATE = "simulate"
    EXPORT = "export"
    QUICK_EXPORT = "quick export"
    READ = "read"
    CHECK = "check"
    COMPARE = "compare"
    LARGEST = "largest"

    @property
    def long(self) -> bool:
        """Whether it may last seconds, and keeps away from the reserved process."""
        return self is Kind.READ or self.gives_way

    @property
    def gives_way(self) -> bool:
        """Whether it is stopped at once when its tab requests something newer."""
        return self not in (Kind.PLAN, Kind.QUICK_EXPORT, Kind.READ)


class Task(ABC):
    """Some work for a process: its kind, what has to be built for it, and how it is worked on."""

    one_at_a_time: ClassVar[bool] = False  # in the whole pool
    # time (s) that it may take; None: as long as it gives signs of life
    limit: ClassVar[float | None] = None

    @property
    @abstractmethod
    def kind(self) -> Kind:
        """Its kind, one of each of which a tab has running at a time."""

    @property
    def needs(self) -> Hashable:
        """The robot or the solver that has to be built first; None: nothing."""
        return None

    @property
    def parts(self) -> tuple[Task, ...]:
        """Tasks that processes work on side by side, in place of this one; it alone: not so."""
        return (self,)

    def work(self, planner: Any, talk: Talk) -> Outcome:
        """Have a process' planner do it, or raise `Error`; not called where it has parts."""
        raise NotImplementedError


@dataclass(frozen=True)
class Prepare(Task):
    """Compute or load all that drawing a robot needs."""

    robot: str  # its name
    kind = Kind.PLAN  # comes before its plan

    @property
    def needs(self) -> Hashable:
        return self.robot

    def work(self, planner: Any, talk: Talk) -> Outcome:
        planner.prepare(self.robot, talk.progress)
        return Prepared(talk.job, self.robot)


@dataclass(frozen=True)
class PlanJump(Task):
    """Plan a jump."""

    jump: Jump  # the request
    tuning: Tuning = field(default_factory=Tuning)  # weights and limits in place of the robot's own
    # a plan to start from, if it is of use for that: one of the same solver that converged
    near: Plan | None = None
    patient: bool = True  # try all there is when the quick attempts fail
    alone: bool = False  # only quick attempts at the request itself, and no nearer jump
    whole_body: bool = False  # at once, where the robot's table of solved jumps is sure of it
    kind = Kind.PLAN

    @property
    def needs(self) -> Solver:
        return solver_of(self.jump, self.tuning)

    def work(self, planner: Any, talk: Talk) -> Outcome:
        try:
            return Planned(talk.job, planner.plan(self, talk.progress, talk.cancelled))
        except NotConverged as error:
            reason = error.reason or str(error)
            return Refused(talk.job, self.jump, reason, error.plan, error.nearest)


@dataclass(frozen=True)
class LoadSolver(PlanJump):
    """Plan a jump to have its solvers at hand, for steps of a slider and the whole body as well."""

    def work(self, planner: Any, talk: Talk) -> Outcome:
        found = super().work(planner, talk)
        if isinstance(found, Planned):
            PlanJump(self.jump, self.tuning, near=found.plan, alone=True).work(planner, talk)
            RefinePlan(found.plan, self.jump).work(planner, talk)
        return found


@dataclass(frozen=True, eq=False)
class RefinePlan(Task):
    """Find the whole body's plan from a centroidal one, or that of a jump that does less."""

    plan: Plan  # a solved one
    wanted: Jump  # what was asked for, of which it is the plan or the nearest one
    kind = Kind.REFINE

    @property
    def needs(self) -> Hashable:
        return "whole body", *solver_of(self.plan.jump)

    def work(self, planner: Any, talk: Talk) -> Outcome:
        try:
            return Planned(talk.job, planner.refine(self, talk.progress, talk.cancelled))
        except NotConverged as error:
            return Refused(talk.job, self.wanted, error.reason, error.plan, error.nearest)


@dataclass(frozen=True)
class FindLargest(Task):
    """Look for the largest jump in one direction."""

    jump: Jump  # the request
    tuning: Tuning  # weights and limits in place of the robot's own
    towards: str  # a name of `llsrbm.largest_jump.DIRECTIONS`
    kind = Kind.LARGEST
    one_at_a_time = True  # it takes minutes: one keeps one process busy, not all of them

    @property
    def needs(self) -> Hashable:
        return "whole body", *solver_of(self.jump)

    def work(self, planner: Any, talk: Talk) -> Outcome:
        try:
            return FoundLargest(talk.job, planner.largest(self, talk.progress, talk.cancelled))
        except NotConverged as error:
            return Refused(talk.job, self.jump, error.reason or str(error), error.plan)


@dataclass(frozen=True, eq=False)
class SimulateJump(Task):
    """Follow a plan with the whole robot."""

    plan: Plan  # a solved one
    scenario: Scenario  # board and disturbance
    wire: bool = False  # by the player, through what a robot's own wire does to it
    kind = Kind.SIMULATE

    def work(self, planner: Any, talk: Talk) -> Outcome:
        return Simulated(
            talk.job, planner.simulate(self, talk.progress, talk.so_far, talk.cancelled)
        )


@dataclass(frozen=True, eq=False)
class SimulateSeeds(Task):
    """Follow a plan once with each seed's disturbance, to see how many land."""

    plan: Plan  # a solved one
    scenario: Scenario  # board and noise; its own seed does not matter
    seeds: tuple[int, ...]  # different ones, in the order in which they are simulated
    kind = Kind.SIMULATE

    @property
    def parts(self) -> tuple[Task, ...]:
        return tuple(SimulateJump(self.plan, self.scenario.but(seed=s)) for s in self.seeds)


@dataclass(frozen=True)
class PlanWay(PlanJump):
    """Plan a jump in one of several ways, with patience only where that is needed."""

    def work(self, planner: Any, talk: Talk) -> Outcome:
        found = PlanJump(self.jump, self.tuning, alone=True).work(planner, talk)
        if isinstance(found, Planned):
            return found
        return PlanJump(self.jump, self.tuning).work(planner, talk)


@dataclass(frozen=True, eq=False)
class FollowWay(SimulateJump):
    """Follow the plan of one of several ways; its motion comes at the end."""

    kind = Kind.COMPARE

    def work(self, planner: Any, talk: Talk) -> Outcome:
        return super().work(planner, replace(talk, send=talk.briefly))


@dataclass(frozen=True, eq=False)
class OpenFile(Task):
    """Read a visitor's file, and prepare its robot."""

    name: str  # of the file, as the browser has it
    content: bytes  # of the file
    robot: str  # for files that do not name one
    fps: float | None = None  # frames/s, likewise; None: the file has to state it
    kind = Kind.READ
    one_at_a_time = True  # a hostile file keeps one process busy, not all of them
    limit = READING_LIMIT

    def work(self, planner: Any, talk: Talk) -> Outcome:
        return Opened(talk.job, planner.open(self, talk.progress))


@dataclass(frozen=True, eq=False)
class OpenMotion(Task):
    """Open a motion of the library that ships, and prepare its robot."""

    name: str
    kind = Kind.READ
    limit = READING_LIMIT

    def work(self, planner: Any, talk: Talk) -> Outcome:
        return Opened(talk.job, planner.open_motion(self, talk.progress))


@dataclass(frozen=True, eq=False)
class ExportMotion(Task):
    """Write a plan or a rollout in other formats."""

    trajectory: Plan | Rollout  # to be written
    formats: tuple[str, ...]  # their names
    zipped: bool = False  # into one zip, with a description; several are in any case
    options: Mapping[str, Any] = field(default_factory=dict)  # as `llsrbm.export` takes them

    @property
    def kind(self) -> Kind:
        # Numbers alone, no meshes and no pictures: surely less than a second.
        quick = all(find(name).suffix in _NUMBERS for name in self.formats)
        return Kind.QUICK_EXPORT if quick else Kind.EXPORT

    def work(self, planner: Any, talk: Talk) -> Outcome:
        return Exported(talk.job, *planner.export(self, talk.progress))


@dataclass(frozen=True, eq=False)
class CheckMotion(Task):
    """Make the certificate of a plan, a rollout or another tool's motion."""

    motion: Plan | Rollout | States
    kind = Kind.CHECK

    def work(self, planner: Any, talk: Talk) -> Outcome:
        return Checked(talk.job, planner.check(self, talk.progress))


@dataclass(frozen=True, eq=False)
class CheckForeign(CheckMotion):
    """Make the certificate of another tool's motion that was opened."""


@dataclass(frozen=True, eq=False)
class RepairMotion(Task):
    """Find the plan nearest to another tool's motion whose certificate holds."""

    motion: States
    kind = Kind.REPAIR

    @property
    def needs(self) -> Hashable:
        return "repair", self.motion.robot  # which solver it takes is known once its feet are seen

    def work(self, planner: Any, talk: Talk) -> Outcome:
        return Repaired(talk.job, planner.repair(self, talk.progress, talk.cancelled))


Solver = tuple[str, str, str, int, str, bool]
"""Requests that one solver works on: robot, model, jump type and hops (the phases), arms, and
whether the apex is limited."""


def solver_of(jump: Jump, tuning: Tuning | None = None) -> Solver:
    """The solver that a request needs."""
    apex = tuning is not None and limits_apex(tuning.limits)
    return jump.robot, jump.model, jump.type, jump.jumps, jump.arms, apex


@dataclass(frozen=True)
class Job:
    """One task to work on, under its number."""

    number: int
    task: Task


PlannerFactory = Callable[[], Any]
"""Makes the planner (`app.workers.worker.LibraryPlanner`) inside a process; an importable function
or class, found there by name. Tasks call its methods."""
