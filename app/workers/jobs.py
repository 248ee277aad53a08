"""All jobs of the pool, waiting and running, under one lock; and the way of their reports.

Listeners are called outside the lock, by two threads, in the order in which the reports came about:
one calls those of tabs; the other calls the warm-up's and writes the log, whose terminal may not be
read by anybody. So neither a slow listener nor a full terminal holds up the work.
"""

from __future__ import annotations

import itertools
import logging
import threading
import time
from collections.abc import Hashable, Sequence
from dataclasses import replace
from functools import partial

from app.workers.deliveries import Call, Deliveries
from app.workers.member import SILENCE, PoolMember
from app.workers.protocol import (
    Cancelled,
    Failed,
    Job,
    PlanJump,
    Planned,
    Progress,
    Ready,
    Report,
    SeedDone,
    SimulatedSoFar,
    Task,
    solver_of,
)
from app.workers.scheduler import Entry, Kind, Scheduler
from app.workers.warm_up import Background

# Least time between two pieces of progress of a job, s.
PROGRESS_INTERVAL = 0.1
# A tab that waits gets to know the reason after this time and then again and again, s.
WAITING_INTERVAL = 0.5
_DRAIN = 1.0  # s for reports that are under way when the pool closes

_log = logging.getLogger(__name__)


class Jobs:
    """The queue, and the job of each process.

    Attributes:
        lock: held for all that follows, never for long: nothing in it waits or touches a disk.
        turns: the queue.
        workers: the processes; of them the job and its times, the rest is the dispatcher's.
        background: the warm-up.
        refusal: the answer to all requests; "" as long as they are taken.
        closed: whether the pool shall end.
    """

    def __init__(self, workers: Sequence[PoolMember]) -> None:
        """No job waits, none runs.

        Args:
            workers: the processes of the pool.
        """
        self.lock = threading.RLock()
        self.turns = Scheduler()
        self.workers = tuple(workers)
        self.background = Background(self.workers, self.turns)
        self.refusal = ""
        self.closed = False
        self._numbers = itertools.count(1)
        self._reports = Deliveries("reports")
        self._asides = Deliveries("asides")

    def number(self) -> int:
        """A number for a new job."""
        return next(self._numbers)

    # ---- reports

    def report(self, entry: Entry, report: Report) -> None:
        """Have the listener called, soon; under the lock, which keeps the order of reports."""
        calls = self._asides if self.background.owns(entry) else self._reports
        # Not bound to its listener yet: a tab that goes meanwhile gets nothing any more.
        calls.put(lambda: entry.listener(report))

    def fail(self, entry: Entry | None, message: str) -> None:
        """Report it to the job's tab, if there is one that waits; under the lock."""
        if entry is not None:
            self.report(entry, Failed(entry.job.number, message))

    def fail_all(self, message: str) -> None:
        """Fail all jobs that a tab waits for; under the lock."""
        for member in self.workers:
            self.fail(member.finish(), message)
        for entry in self.turns.clear():
            self.fail(entry, message)

    def fail_warm_up(self, message: str) -> None:
        """Report it to the listener of the warm-up, if it is not through."""
        if self.background.awaited:
            self._asides.put(partial(self.background.listener, Failed(0, message)))

    def note(self, text: str, *values: object, error: Exception | None = None) -> None:
        """Log it, without waiting for a terminal that is not read."""
        self._asides.put(partial(_log.error, text, *values, exc_info=error))

    def put_aside(self, call: Call) -> None:
        """Have a call made that may take its time, after those put before."""
        self._asides.put(call)

    def close(self) -> None:
        """End the threads that call listeners, when all calls are made or after a second each."""
        self._reports.close(_DRAIN)
        self._asides.close(_DRAIN)

    # ---- the jobs; under the lock

    def supersede(
        self, member: PoolMember, tab: Hashable, newer: Task, now: float, grace: float
    ) -> None:
        """Have a running job of the tab stop in favour of a newer one, if it may take long.

        Args:
            member: whose job it is.
            tab: that requests the newer one.
            newer: task.
            now: s.
            grace: how long a patient plan may go on, s.
        """
        entry = member.working_on
        if entry is None or entry.tab != tab or member.stop_at is not None or member.stopping:
            return
        task = entry.job.task
        patient = isinstance(task, PlanJump) and task.patient
        hurried = isinstance(newer, PlanJump) and not newer.patient
        if Kind.of(task).long or (patient and hurried):
            # The hand that rested has moved on, and the plan for its new place is not to wait.
            member.stop_at = now
        elif patient:
            member.stop_at = now + grace

    def give_up(self, tab: Hashable, grace: float) -> list[Entry]:
        """Withdraw the tab's jobs, in order, under the lock; running ones end within `grace`, s."""
        waiting = self.turns.withdraw(tab)
        entries = [] if waiting is None else [waiting]
        for member in self.workers:
            entry = member.working_on
            if entry is not None and entry.tab == tab and member.wanted:
                entries.append(entry)
                member.wanted = False
                member.ask_to_stop()
                member.end_at = time.monotonic() + grace
        return sorted(entries, key=lambda entry: entry.job.number)

    def next(self) -> tuple[Entry, PoolMember] | None:
        """The job to work on next, a tab's or the warm-up's, and the process that takes it."""
        turn = self.turns.next(self.workers)
        if turn is not None:
            return turn
        loading = self.background.next()
        if loading is None:
            return None
        member, task, listener = loading
        job = Job(self.number(), task)
        return Entry(self.background, job, listener, time.monotonic()), member

    def receive(self, member: PoolMember, message: Ready | Report) -> None:
        """Take a message of a process and report it to the job's tab."""
        if isinstance(message, Ready):
            member.ready = True
            return
        entry = member.working_on
        if entry is None or entry.job.number != message.job:
            return
        now = time.monotonic()
        member.silent_by = now + SILENCE
        if isinstance(message, Progress):
            member.activity, member.progress = message.text, message
            self.report_progress(member, entry, now)
            return
        if isinstance(message, SimulatedSoFar | SeedDone):
            if member.wanted:
                self.report(entry, message)
            return
        task = entry.job.task
        listening = member.finish()
        if not isinstance(message, Cancelled):
            self.turns.note_done(task)
        if isinstance(message, Planned) and isinstance(task, PlanJump):
            member.loaded[solver_of(task.jump)] = replace(task, near=None)
        if listening is not None:
            self.report(listening, message)

    def report_progress(self, member: PoolMember, entry: Entry, now: float) -> None:
        """Report the newest progress, unless there was some a moment ago; it waits then."""
        if member.progress is not None and now >= member.notify_at:
            if member.wanted:
                self.report(entry, member.progress)
            member.progress, member.notify_at = None, now + PROGRESS_INTERVAL

    def notify_waiting(self, now: float) -> None:
        """Report to tabs that wait the reason, those whose time has come."""
        busy = sorted(
            (
                (m.working_on, m.activity)
                for m in self.workers
                if m.working_on is not None and m.activity
            ),
            key=lambda pair: pair[0].job.number,
        )
        for entry in self.turns:
            if now < entry.notify_at:
                continue
            entry.notify_at = now + WAITING_INTERVAL
            # For its tab's own job if there is one, else for the one that takes longest.
            others = [activity for other, activity in busy if other.tab == entry.tab]
            others += [activity for _, activity in busy] or ["the computing process starts"]
            self.report(entry, Progress(entry.job.number, f"waiting: {others[0]}"))
