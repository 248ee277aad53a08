"""Whose job is next, and on which process: the rules by which tabs share the pool.

1. Tabs take turns in the order in which they asked. A tab has one job waiting; a newer one takes
   its place in the queue, so that a slider dragged in one tab cannot starve another.
2. Of each kind (planning, searching, simulating, files) a tab has at most one job running, besides
   those that were asked to stop.
3. One process is reserved: it takes nothing that lasts seconds, so that no plan has to wait for
   another tab's simulation.
4. What no process has done yet (a solver that may have to be built, a robot that may have to be
   prepared) runs on one process at a time: the others stay free, and nothing is built twice.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import TypeVar

from app.compute.protocol import (
    ExportMotion,
    FindNearest,
    Job,
    OpenFile,
    PlanJump,
    Prepare,
    Report,
    SimulateJump,
    Task,
)

_log = logging.getLogger(__name__)

Listener = Callable[[Report], None]
Solver = tuple[str, str]  # robot, model


class Kind(Enum):
    """What a tab can have going on, one of each at a time."""

    PLAN = 0
    SEARCH = 1
    SIMULATE = 2
    EXPORT = 3
    FILE = 4  # opened, or written quickly

    @staticmethod
    def of(task: Task) -> Kind:
        """A task's; preparing a robot comes before its plan, and counts as such."""
        match task:
            case FindNearest():
                return Kind.SEARCH
            case SimulateJump():
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
    """A job and who asked for it.

    Attributes:
        tab: who.
        job: what.
        listener: hears its reports.
        tell_at: when it is to be told what it waits for, if it still does, s (monotonic clock).
    """

    tab: Hashable
    job: Job
    listener: Listener
    tell_at: float

    def tell(self, report: Report) -> None:
        """Have the listener hear; what goes wrong there must not stop other tabs' jobs."""
        try:
            self.listener(report)
        except Exception:  # noqa: BLE001  # whatever it is
            _log.exception("the listener of job %d failed", self.job.number)


@dataclass(eq=False)
class Member:
    """One process of the pool, as far as turns go.

    Attributes:
        reserved: takes nothing that lasts seconds.
        loaded: the solvers it has at hand, each with a task that it has solved.
        ready: it has started.
        working_on: the job it has.
        stopping: that was asked to stop, but may take its time.
    """

    reserved: bool
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
        """Nobody waits, and nothing was done yet."""
        self._waiting: dict[Hashable, Entry] = {}
        self._done: set[Hashable] = set()

    def __iter__(self) -> Iterator[Entry]:
        return iter(tuple(self._waiting.values()))

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, entry: Entry) -> None:
        """Queue it, or in place of the one of its tab that waits."""
        self._waiting[entry.tab] = entry

    def withdraw(self, tab: Hashable) -> Entry | None:
        """The tab's waiting job, which leaves the queue."""
        return self._waiting.pop(tab, None)

    def note_done(self, task: Task) -> None:
        """It has been worked on: what it needs is there, at least on the disk."""
        self._done.add(_needs(task))

    def clear(self) -> list[Entry]:
        """All waiting jobs, which leave the queue."""
        entries = list(self._waiting.values())
        self._waiting.clear()
        return entries

    def next(self, members: Sequence[AnyMember]) -> tuple[Entry, AnyMember] | None:
        """The first waiting job that one of the members can take, and which; leaves the queue."""
        running = {
            _claim(m.working_on) for m in members if m.working_on is not None and not m.stopping
        }
        for entry in self._waiting.values():
            if _claim(entry) in running or not self.may_run(entry.job.task, members):
                continue
            long = Kind.of(entry.job.task).long
            able = [m for m in members if m.idle and not (m.reserved and long)]
            if able:
                del self._waiting[entry.tab]
                return entry, min(able, key=lambda m: self._reluctance(m, entry.job.task))
        return None

    def is_new(self, task: Task) -> bool:
        """Whether it may take long for the sake of what it needs first."""
        needed = _needs(task)
        return needed is not None and needed not in self._done

    def may_run(self, task: Task, members: Sequence[Member]) -> bool:
        """Whether it needs nothing new while another member works on something new."""
        return not self.is_new(task) or not any(
            self.is_new(m.working_on.job.task) for m in members if m.working_on is not None
        )

    def _reluctance(self, member: Member, task: Task) -> tuple[bool, bool]:
        """Sorts members: who has the solver; then the reserved one, unless it may take long."""
        loaded = _needs(task) in member.loaded
        return not loaded, member.reserved == (self.is_new(task) or Kind.of(task).long)


def _claim(entry: Entry) -> tuple[Hashable, Kind]:
    return entry.tab, Kind.of(entry.job.task)


def _needs(task: Task) -> Hashable:
    """What has to be there first: a robot, or a solver; None where nothing has."""
    if isinstance(task, Prepare):
        return task.robot
    if isinstance(task, SimulateJump | OpenFile | ExportMotion):
        return None
    return task.jump.robot, task.jump.model
