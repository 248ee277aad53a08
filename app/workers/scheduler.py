"""The order of jobs, and the process that takes each: the rules by which tabs share the pool.

1. Tabs take turns in the order of their requests. A tab has one job waiting; a newer one takes its
   place in the queue, so that a slider dragged in one tab cannot starve another.
2. Of each kind (planning, searching, simulating, files) a tab has at most one job running, besides
   those that were asked to stop.
3. One process is reserved: it takes no job that lasts seconds, so that no plan has to wait for
   another tab's simulation.
4. A job that may have to build something first (a solver, a robot's meshes) runs on one process at
   a time: the others stay free, and nothing is built twice.
5. A process of another machine takes nothing that is about files of this one: its meshes, a
   visitor's file, an export, whose packages that machine may lack. It is the first to be given what
   lasts seconds, and the last for what is short.
6. At most `MOST_WAITING` jobs wait; beyond that new tabs are refused until the queue is shorter.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import TypeVar

from app.workers.protocol import (
    ExportMotion,
    FindNearest,
    Job,
    OpenFile,
    PlanJump,
    Prepare,
    Report,
    SimulateJump,
    SimulateSeeds,
    Solver,
    Task,
    solver_of,
)

MOST_WAITING = 200
"""Jobs in the queue: of some 60 tabs that plan, open and save at once; a job may hold a file of
32 MB, so that the queue needs a bound."""

Listener = Callable[[Report], None]


class Kind(Enum):
    """Kinds of jobs; a tab has one of each running at a time."""

    PLAN = 0
    SEARCH = 1
    SIMULATE = 2
    EXPORT = 3
    FILE = 4  # opened, or written quickly

    @staticmethod
    def of(task: Task) -> Kind:
        """The task's kind; preparing a robot comes before its plan, and counts as such."""
        match task:
            case FindNearest():
                return Kind.SEARCH
            case SimulateJump() | SimulateSeeds():
                return Kind.SIMULATE
            case ExportMotion():
                return Kind.FILE if task.quick else Kind.EXPORT
            case OpenFile():
                return Kind.FILE
        return Kind.PLAN

    @property
    def long(self) -> bool:
        """Whether it lasts seconds."""
        return self in (Kind.SEARCH, Kind.SIMULATE, Kind.EXPORT)


@dataclass(eq=False)
class Entry:
    """A job in the queue or on a process, and the tab that it is for.

    Attributes:
        tab: any name of it that can be a key.
        job: the work.
        listener: called with its reports.
        notify_at: when its tab gets to know the reason for waiting, s (monotonic clock).
    """

    tab: Hashable
    job: Job
    listener: Listener
    notify_at: float


@dataclass(eq=False)
class Member:
    """One process of the pool, as far as the order of jobs goes.

    Attributes:
        reserved: takes no job that lasts seconds.
        remote: on another machine; takes no job that is about files of this one.
        loaded: the solvers in its memory, each with a task that it has solved.
        ready: it has started.
        working_on: its job, if it has one.
        stopping: whether that job was asked to stop; it may go on for a while.
    """

    reserved: bool
    remote: bool = False
    loaded: dict[Solver, PlanJump] = field(default_factory=dict)
    ready: bool = False
    working_on: Entry | None = None
    stopping: bool = False

    @property
    def idle(self) -> bool:
        """Whether it can take a job."""
        return self.ready and self.working_on is None


AnyMember = TypeVar("AnyMember", bound=Member)


class Scheduler:
    """The jobs that wait."""

    def __init__(self) -> None:
        """An empty queue; nothing is known to be built."""
        self._waiting: dict[Hashable, Entry] = {}
        self._done: set[Hashable] = set()

    def __iter__(self) -> Iterator[Entry]:
        return iter(tuple(self._waiting.values()))

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, entry: Entry) -> None:
        """Queue it, or in place of its tab's waiting job; not if `is_full_for` its tab."""
        self._waiting[entry.tab] = entry

    def is_full_for(self, tab: Hashable) -> bool:
        """Whether no further job can wait, except in place of one of the same tab."""
        return len(self._waiting) >= MOST_WAITING and tab not in self._waiting

    def withdraw(self, tab: Hashable) -> Entry | None:
        """Take the tab's waiting job out of the queue."""
        return self._waiting.pop(tab, None)

    def note_done(self, task: Task) -> None:
        """A job was worked on: its solver or meshes are built, at least on the disk."""
        self._done.add(_needs(task))

    def clear(self) -> list[Entry]:
        """Take all waiting jobs out of the queue."""
        entries = list(self._waiting.values())
        self._waiting.clear()
        return entries

    def next(self, members: Sequence[AnyMember]) -> tuple[Entry, AnyMember] | None:
        """Take the first job out of the queue that a member can take; the job and the member."""
        running = {
            _claim(m.working_on) for m in members if m.working_on is not None and not m.stopping
        }
        for entry in self._waiting.values():
            if _claim(entry) in running or not self.may_run(entry.job.task, members):
                continue
            able = [m for m in members if m.idle and _suits(m, entry.job.task)]
            if able:
                del self._waiting[entry.tab]
                return entry, min(able, key=lambda m: self._reluctance(m, entry.job.task))
        return None

    def is_new(self, task: Task) -> bool:
        """Whether it may have to build something first, which may take long."""
        needed = _needs(task)
        return needed is not None and needed not in self._done

    def may_run(self, task: Task, members: Sequence[Member]) -> bool:
        """Whether it builds nothing, or no other member is building."""
        return not self.is_new(task) or not any(
            self.is_new(m.working_on.job.task) for m in members if m.working_on is not None
        )

    def _reluctance(self, member: Member, task: Task) -> tuple[bool, bool, bool]:
        """Sorts members: with the solver first; then a reserved one, unless it may take long."""
        loaded = _needs(task) in member.loaded
        long = Kind.of(task).long
        return not loaded, member.reserved == (self.is_new(task) or long), member.remote != long


def _suits(member: Member, task: Task) -> bool:
    """Whether a member may take a task at all, once it has time."""
    here = isinstance(task, Prepare | OpenFile | ExportMotion)
    return not (member.reserved and Kind.of(task).long) and not (member.remote and here)


def _claim(entry: Entry) -> tuple[Hashable, Kind]:
    return entry.tab, Kind.of(entry.job.task)


def _needs(task: Task) -> Hashable:
    """The robot or the solver that has to be built first; None where there is none."""
    if isinstance(task, Prepare):
        return task.robot
    if isinstance(task, SimulateJump | SimulateSeeds | OpenFile | ExportMotion):
        return None
    return solver_of(task.jump)
