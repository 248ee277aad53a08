"""The jobs of the pool, waiting and running, and the way of their reports: all under one lock."""

from __future__ import annotations

import itertools
import logging
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from functools import partial

from app.workers import reports, tasks
from app.workers.deliveries import Deliveries
from app.workers.member import SILENCE, Entry, Member
from app.workers.waiting import Waiting

# A second unforeseen exception within this time of the first is a lasting defect, s: replacing the
# processes takes a second or two and did not help.
REPEATED_FAILURE = 10.0
PROGRESS_INTERVAL = 0.1  # least time between two pieces of progress of a job, s
# A tab that waits gets to know the reason after this time and then again and again, s.
WAITING_INTERVAL = 0.5

DEFECT = "A defect of the server interrupted this; please try again."
BROKEN = "The server has a lasting defect and computes nothing any more; the terminal says more."
SILENT = f"It gave no sign of life for {SILENCE / 60:g} minutes and was stopped."
LATE = "It took more than {limit:g} s and was stopped."

_log = logging.getLogger("app.workers.pool")


class Jobs(ABC):
    """The queue, and the job of each process; all methods are called under the lock."""

    def __init__(self, members: Sequence[Member], cancel_grace: float) -> None:
        """`cancel_grace`: how long a cancelled job may go on before its process is killed, s."""
        self._workers = tuple(members)
        self._cancel_grace = cancel_grace
        self._lock = threading.RLock()
        self._changed = threading.Condition(self._lock)
        self._waiting = Waiting()
        self._numbers = itertools.count(1)
        self._refusal = ""  # the answer to all requests; "" as long as they are taken
        self._failed_at: float | None = None  # time of the last unforeseen exception
        self._warm_up_listener: reports.Listener = ignore
        self._warm_up_done: Callable[[], None] | None = None
        self._reports, self._asides = Deliveries("reports"), Deliveries("asides")

    @abstractmethod
    def _start_processes(self) -> None:
        """Start those that are wanted."""

    def _receive(self, member: Member, message: reports.Ready | reports.Report) -> None:
        if isinstance(message, reports.Ready):
            member.ready = not member.ending
            self._hand_out()
            return
        entry, task = member.working_on, member.task
        if entry is None or task is None or entry.number != message.job or member.ending:
            return
        now = time.monotonic()
        member.silent_by = now + SILENCE
        if isinstance(message, reports.Progress):
            member.activity, member.progress = message.text, message
            self._report_progress(member, entry, now)
            return
        if isinstance(message, reports.SimulatedSoFar):
            self._report(entry, message, task)
            return
        member.finish()
        if not isinstance(message, reports.Cancelled):
            self._waiting.note_done(task)
        if isinstance(message, reports.Planned) and isinstance(task, tasks.PlanJump):
            member.loaded[task.needs] = replace(task, near=None)
        self._report(entry, message, task)
        self._cancel_remains(entry)
        self._hand_out()

    def _cancel_remains(self, entry: Entry) -> None:
        running = any(member.working_on is entry for member in self._workers)
        if not (entry.over or running or self._waiting.get(entry.tab) is entry):
            self._report(entry, reports.Cancelled(entry.number))

    def _keep_deadlines(self, now: float) -> float | None:
        """Do what is due; when something will be, s."""
        due: list[float] = []
        for member in self._workers:
            entry = member.working_on
            if entry is not None and not member.ending:
                self._keep_deadlines_of_job(member, entry, now)
                times = (member.stop_at, member.end_at, member.silent_by)
                due += [at for at in times if at is not None]
                if member.progress is not None:
                    due.append(member.notify_at)
            elif member.running and not member.ready and not member.ending:
                if now >= member.start_by:
                    self._note("a computing process was not ready in time")
                    member.process.kill()
                    member.start_by = now + member.process.start_patience
                due.append(member.start_by)
        self._notify_waiting(now)
        due += [entry.notify_at for entry in self._waiting]
        return min(due, default=None)

    def _keep_deadlines_of_job(self, member: Member, entry: Entry, now: float) -> None:
        self._report_progress(member, entry, now)
        if member.stop_at is not None and now >= member.stop_at:
            member.request_stop()
            member.stop_at = None
            self._hand_out()  # what its tab wants instead
        late = member.end_at is not None and now >= member.end_at
        if late or now >= member.silent_by:
            limit = member.task.limit if member.task is not None else None
            message = LATE.format(limit=limit) if late and limit else SILENT
            self._report(entry, reports.Failed(entry.number, message))
            member.finish()
            member.plan_to_restore(but=None)
            member.kill()

    def _report_progress(self, member: Member, entry: Entry, now: float) -> None:
        if member.progress is not None and now >= member.notify_at:
            self._report(entry, member.progress, member.task)
            member.progress, member.notify_at = None, now + PROGRESS_INTERVAL
        elif member.progress is not None:
            self._changed.notify_all()

    def _notify_waiting(self, now: float) -> None:
        busy = [(m.working_on, m.activity) for m in self._workers if m.working_on and m.activity]
        busy.sort(key=lambda pair: pair[0].number)
        for entry in self._waiting:
            if now < entry.notify_at:
                continue
            entry.notify_at = now + WAITING_INTERVAL
            if any(member.working_on is entry for member in self._workers):
                continue  # some of its parts run
            # For its tab's own job if there is one, else for the one that takes longest.
            others = [activity for other, activity in busy if other.tab == entry.tab]
            others += [activity for _, activity in busy] or ["the computing process starts"]
            self._report(
                entry, reports.Progress(entry.number, f"waiting: {others[0]}", waiting=True)
            )

    def _hand_out(self) -> None:
        """Give jobs to the processes that can take them, a tab's first, then the warm-up's."""
        try:
            while (turn := self._waiting.next(self._workers) or self._next_to_load()) is not None:
                entry, task, member = turn
                job = member.begin(entry, task, time.monotonic())
                member.process.send(job, partial(self._unsendable, member, entry))
            self._start_processes()
            first = self._workers[0]
            starting = first.may_start and not first.ready
            through = not (first.todo or first.working_on is not None or starting)
            if self._warm_up_done is not None and through:
                self._asides.put(self._warm_up_done)
                self._warm_up_done = None
        except Exception as error:  # noqa: BLE001  # the last resort: whatever it is
            self._recover(error)
        self._changed.notify_all()

    def _next_to_load(self) -> tuple[Entry, tasks.Task, Member] | None:
        """A process with time, and a task of its `todo`; one at a time, so that others are free."""
        if any(m.working_on is not None and m.working_on.tab is self for m in self._workers):
            return None
        for member in self._workers:
            if member.idle and member.todo:
                task = member.todo[0]
                blocked = self._waiting.is_new(task) and member.reserved
                if not blocked and self._waiting.may_run(task, self._workers):
                    del member.todo[0]
                    reported = self._warm_up_done is not None and member is self._workers[0]
                    listener = self._warm_up_listener if reported else ignore
                    return Entry(self, next(self._numbers), task, listener), task, member
        return None

    def _give_up(self, tab: Hashable, grace: float) -> list[Entry]:
        """Withdraw the tab's jobs, in order; running ones end within `grace`, s."""
        waiting = self._waiting.withdraw(tab)
        entries = {} if waiting is None else {waiting.number: waiting}
        for member in self._workers:
            entry = member.working_on
            if entry is not None and entry.tab == tab and not entry.over:
                entries[entry.number] = entry
                member.request_stop()
                member.end_at = time.monotonic() + grace
        self._hand_out()
        return [entries[number] for number in sorted(entries)]

    def _report(self, entry: Entry, report: reports.Report, task: tasks.Task | None = None) -> None:
        """Have the listener called, soon, with a report on a job or on its part; in order."""
        passed_on = [report]
        if entry.batch is not None and isinstance(task, tasks.SimulateJump):
            passed_on = entry.batch.take(task, report)
        for each in passed_on:
            if entry.over:
                return
            if not isinstance(each, reports.Partial):
                entry.over = True
                self._stop_parts(entry)
            calls = self._asides if entry.tab is self else self._reports
            calls.put(partial(_deliver, entry, each))

    def _stop_parts(self, entry: Entry) -> None:
        if entry.parts and self._waiting.get(entry.tab) is entry:
            self._waiting.withdraw(entry.tab)
        for member in self._workers:
            if member.working_on is entry and not member.stopping:
                member.request_stop()
                member.end_at = time.monotonic() + self._cancel_grace

    def _fail_all(self, message: str) -> None:
        for entry in self._waiting.clear():
            self._report(entry, reports.Failed(entry.number, message))
        for member in self._workers:
            left = member.finish()
            if left is not None and left.tab is not self:
                self._report(left, reports.Failed(left.number, message))

    def _fail_warm_up(self, message: str) -> None:
        if self._warm_up_done is not None:
            self._asides.put(partial(self._warm_up_listener, reports.Failed(0, message)))

    def _unsendable(self, member: Member, entry: Entry, error: Exception) -> None:
        with self._lock:
            self._note("job %d cannot be sent", entry.number, error=error)
            if member.working_on is entry:
                member.finish()
            self._report(entry, reports.Failed(entry.number, DEFECT))
            self._hand_out()

    def _recover(self, error: Exception) -> None:
        """Fail all jobs and replace all processes; end it all if that did not help before."""
        now = time.monotonic()
        repeated = self._failed_at is not None and now - self._failed_at < REPEATED_FAILURE
        self._failed_at = now
        self._note("a defect in the pool of computing processes", error=error)
        if repeated:
            self._fail_warm_up(BROKEN)
            self._refusal = self._refusal or BROKEN
            self._stop_all(BROKEN)
            return
        self._fail_all(DEFECT)
        for member in self._workers:
            member.plan_to_restore(but=None)
            member.kill()

    def _stop_all(self, message: str) -> None:
        self._fail_all(message)
        for member in self._workers:
            member.kill()
        self._changed.notify_all()

    def _note(self, text: str, *values: object, error: Exception | None = None) -> None:
        """Log it, without waiting for a terminal that is not read."""
        self._asides.put(partial(_log.error, text, *values, exc_info=error))


def _deliver(entry: Entry, report: reports.Report) -> None:
    """Call the listener that the entry has now: a tab that goes meanwhile gets nothing any more."""
    entry.listener(report)


def ignore(_report: reports.Report | str) -> None:
    """Take nothing: of a tab that has gone, of loading, or of a pool without a page."""
