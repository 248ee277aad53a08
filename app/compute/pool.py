"""The pool of computing processes: passes jobs on, reports to tabs, stops jobs, replaces processes.

The order of jobs is decided in `app.compute.scheduler`. A plan that is running when its tab
requests something newer may finish if it is a quick one, because that is shorter than one notices;
if it takes longer it is stopped. A simulation or a search is stopped at once: it is no longer
wanted.

Threads, and what keeps any of them from waiting for ever:

- the pool's own: the only one that starts, feeds and ends processes. It waits for its inbox alone;
  processes are read and written by threads of `app.compute.channel`, and one that ends is looked at
  now and then. An exception here that nothing foresaw fails all jobs and replaces all processes;
  a second one soon after ends the thread, and every request is refused from then on.
- those of tabs: put requests in the queue, under a lock that is never held for long.
- two that call listeners, outside the lock and in the order in which the reports came about: one
  for tabs, one for the warm-up and the log, whose terminal may not be read by anybody.
"""

from __future__ import annotations

import itertools
import logging
import multiprocessing
import os
import queue
import threading
import time
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from functools import partial

from app.compute import worker
from app.compute.channel import Inbox, Received
from app.compute.deliveries import Deliveries
from app.compute.planner import PlannerFactory
from app.compute.process import EXIT_PATIENCE, SILENCE, WorkerProcess
from app.compute.protocol import (
    Cancelled,
    Failed,
    Job,
    PlanJump,
    Planned,
    Prepare,
    Progress,
    Ready,
    Report,
    SeedDone,
    SimulatedSoFar,
    Task,
)
from app.compute.scheduler import MOST_WAITING, Entry, Kind, Listener, Scheduler, Solver
from app.compute.warm_up import Background

# One process plans while another simulates; more than four would mostly cost memory (0.3 GB each).
PROCESSES = min(max(os.cpu_count() or 1, 2), 4)
# How long a cancelled job may go on before its process is ended, s: the rest of the 0.2 s that
# cancelling may take is for ending it.
CANCEL_GRACE = 0.15
# How long a patient plan may go on when its tab wants something newer, s: longer than most take.
SUPERSEDED_GRACE = 0.3
# How long the job of a tab that has gone may go on, s: a solver that is being built (half a minute)
# will be of use, a hung one never.
FORGOTTEN_GRACE = 60.0
# Least time between two pieces of progress of a job, s.
PROGRESS_INTERVAL = 0.1
# A tab that waits gets to know the reason after this time and then again and again, s.
WAITING_INTERVAL = 0.5
# Time between two looks at a process that is ending, s.
POLL_INTERVAL = 0.01
# A second unforeseen exception in the pool's thread within this time of the first is a lasting
# defect, s: replacing the processes takes a second or two and did not help.
REPEATED_FAILURE = 10.0
# How long closing may take, s: processes that do not end are killed after a second of it.
CLOSE_PATIENCE = 5.0

CLOSED = "The server is closing."
DEFECT = "A defect of the server interrupted this; please try again."
BROKEN = "The server has a lasting defect and computes nothing any more; the terminal says more."
BUSY = f"The server is busy: {MOST_WAITING} requests are waiting. Please try again in a moment."

_log = logging.getLogger(__name__)


class WorkerPool:
    """Owns the computing processes and passes them the jobs of all tabs.

    A listener gets its job's reports in order, nothing after the outcome, from a thread of the
    pool's; it must return at once.

    Attributes:
        planner: name of the planner.
    """

    def __init__(
        self,
        factory: PlannerFactory = worker.LibraryPlanner,
        *,
        processes: int = PROCESSES,
        cancel_grace: float = CANCEL_GRACE,
        superseded_grace: float = SUPERSEDED_GRACE,
    ) -> None:
        """Start the first process; the others follow when it has planned something.

        Args:
            factory: makes the planner inside a process.
            processes: how many; with more than one, the last takes nothing that lasts seconds.
            cancel_grace: how long a cancelled job may go on before its process is ended, s.
            superseded_grace: how long a patient plan may go on when its tab wants something newer,
                before it is asked to stop, s.
        """
        self.planner = f"{factory.__module__}.{factory.__qualname__}"
        self._cancel_grace = cancel_grace
        self._superseded_grace = superseded_grace
        self._numbers = itertools.count(1)
        context = multiprocessing.get_context("spawn")
        self._inbox: Inbox = queue.SimpleQueue()
        self._reports = Deliveries("reports")
        self._asides = Deliveries("asides")  # the warm-up's listener, and the log

        # Under the lock: the queue, and the job of each process. The rest is the thread's alone.
        self._lock = threading.RLock()
        self._turns = Scheduler()
        self._workers = [
            WorkerProcess(context, factory, self._inbox, i + 1, reserved=0 < i == processes - 1)
            for i in range(processes)
        ]
        self._background = Background(self._workers, self._turns)
        self._refusal = ""  # of all requests; "" as long as they are taken
        self._closed = False

        self._failed_at: float | None = None  # when the thread met its last unforeseen exception
        self._thread = threading.Thread(target=self._run, name="worker-pool", daemon=True)
        self._thread.start()

    # ---- called by tabs, from any thread

    def submit(self, tab: Hashable, task: Task, listener: Listener) -> int:
        """Queue a task, in place of the tab's waiting one if there is one.

        The replaced one gets no report; a running one still does. A request that cannot be taken,
        because too many wait or the pool has ended, is answered with `Failed` before this returns.

        Args:
            tab: any name of it; a tab has one waiting job under each of its names.
            task: the work.
            listener: called with `Progress` while waiting, then once with the outcome.

        Returns:
            The job's number, larger than that of all jobs before.
        """
        now = time.monotonic()
        with self._lock:
            number = next(self._numbers)
            refusal = self._refusal or (BUSY if self._turns.is_full_for(tab) else "")
            if not refusal:
                self._turns.put(Entry(tab, Job(number, task), listener, now + WAITING_INTERVAL))
                for member in self._workers:
                    member.may_start = True
                    self._supersede(member, tab, task, now)
        if refusal:
            listener(Failed(number, refusal))
        else:
            self._wake()
        return number

    def cancel(self, tab: Hashable) -> None:
        """Give up the tab's jobs, waiting and running; each is `Cancelled` at once."""
        with self._lock:
            for entry in self._give_up(tab, self._cancel_grace):
                self._report(entry, Cancelled(entry.job.number))

    def forget(self, tab: Hashable) -> None:
        """Give up the tab's jobs without a report: the tab has gone."""
        with self._lock:
            for entry in self._give_up(tab, FORGOTTEN_GRACE):
                entry.listener = _ignore  # for reports that are under way

    def warm_up(
        self, tasks: Sequence[Prepare | PlanJump], listener: Listener, done: Callable[[], None]
    ) -> None:
        """Have every process load what is likely to be requested; called once.

        Args:
            tasks: in order; robots are prepared by the first process only, as that is for all.
            listener: called with the reports of the first process; may take its time.
            done: called when the first process is through; the others go on.
        """
        with self._lock:
            self._background.warm_up(tasks, listener, done)
        self._wake()

    def close(self) -> None:
        """End the processes and this object's threads, within `CLOSE_PATIENCE` or little more."""
        with self._lock:
            self._refusal = self._refusal or CLOSED
            self._closed = True
        self._wake()
        self._thread.join(CLOSE_PATIENCE)
        if self._thread.is_alive():
            _log.error("the pool's thread does not end; its processes are killed")
            for member in self._workers:
                member.kill()
        self._reports.close(1.0)
        self._asides.close(1.0)

    @property
    def process_ids(self) -> tuple[int | None, ...]:
        """Of each computing process, None while there is none; the reserved one is the last."""
        return tuple(member.id for member in self._workers)

    def _supersede(self, member: WorkerProcess, tab: Hashable, newer: Task, now: float) -> None:
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
            member.stop_at = now + self._superseded_grace

    def _give_up(self, tab: Hashable, grace: float) -> list[Entry]:
        """Withdraw the tab's jobs, in order, under the lock; running ones end within `grace`, s."""
        waiting = self._turns.withdraw(tab)
        entries = [] if waiting is None else [waiting]
        for member in self._workers:
            entry = member.working_on
            if entry is not None and entry.tab == tab and member.wanted:
                entries.append(entry)
                member.wanted = False
                member.ask_to_stop()
                member.end_at = time.monotonic() + grace
        self._wake()
        return sorted(entries, key=lambda entry: entry.job.number)

    def _wake(self) -> None:
        self._inbox.put(None)

    def _report(self, entry: Entry, report: Report) -> None:
        """Have the listener called, soon; under the lock, which keeps the order of reports."""
        calls = self._asides if self._background.owns(entry) else self._reports
        # Not bound to its listener yet: a tab that goes meanwhile gets nothing any more.
        calls.put(lambda: entry.listener(report))

    # ---- the thread

    def _run(self) -> None:
        try:
            while not self._closed:
                try:
                    self._hand_out()
                    self._start()
                    self._take_messages()
                    self._keep_deadlines()
                except Exception as error:  # noqa: BLE001  # the last resort: whatever it is
                    if not self._recover(error):
                        break
        finally:
            # No request is taken that nobody would work on, even if recovering went wrong.
            self._refusal = self._refusal or BROKEN
            self._end_all()

    def _hand_out(self) -> None:
        while True:
            with self._lock:
                turn = self._next()
                if turn is None:
                    break
                entry, member = turn
                member.begin(entry, time.monotonic())
            try:
                member.send(entry.job)
            except Exception as error:  # noqa: BLE001  # a task that cannot be pickled
                self._note("job %d cannot be sent", entry.job.number, error=error)
                with self._lock:
                    self._fail(member.finish(), DEFECT)
        with self._lock:
            done = self._background.take_done()
        if done is not None:
            self._asides.put(done)

    def _next(self) -> tuple[Entry, WorkerProcess] | None:
        turn = self._turns.next(self._workers)
        if turn is not None:
            return turn
        loading = self._background.next()
        if loading is None:
            return None
        member, task, listener = loading
        job = Job(next(self._numbers), task)
        return Entry(self._background, job, listener, time.monotonic()), member

    def _start(self) -> None:
        first = self._workers[0]
        more = len(self._turns) > 0 or self._background.wants_all_processes()
        for member in self._workers:
            if member.exists or not member.may_start or not (more or member is first):
                continue
            try:
                member.start(time.monotonic())
            except OSError as error:
                self._note("a computing process cannot be started", error=error)
                self._does_not_start(member, f"{error.strerror or error}")

    def _take_messages(self) -> None:
        due = self._next_deadline()
        timeout = None if due is None else max(0.0, due - time.monotonic())
        try:
            received = self._inbox.get(timeout=timeout)
        except queue.Empty:
            return
        while True:
            if received is not None:
                self._take(received)
            try:
                received = self._inbox.get_nowait()
            except queue.Empty:
                return

    def _take(self, received: Received) -> None:
        member = next((m for m in self._workers if m.channel is received.channel), None)
        if member is None:
            return  # of a process that is ending
        if received.message is None:
            member.end(time.monotonic(), EXIT_PATIENCE, unexpected=True)
            return
        with self._lock:
            self._receive(member, received.message)

    def _next_deadline(self) -> float | None:
        with self._lock:
            due = []
            for member in self._workers:
                due += [at for at in (member.stop_at, member.end_at) if at is not None]
                if member.progress is not None:
                    due.append(member.notify_at)
                if member.ending:
                    due.append(time.monotonic() + POLL_INTERVAL)
                elif member.starting:
                    due.append(member.start_by)
                elif member.working_on is not None:
                    due.append(member.silent_by)
            due += [entry.notify_at for entry in self._turns]
        return min(due, default=None)

    def _receive(self, member: WorkerProcess, message: Ready | Report) -> None:
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
            self._report_progress(member, entry, now)
            return
        if isinstance(message, SimulatedSoFar | SeedDone):
            if member.wanted:
                self._report(entry, message)
            return
        task = entry.job.task
        listening = member.finish()
        if not isinstance(message, Cancelled):
            self._turns.note_done(task)
        if isinstance(message, Planned) and isinstance(task, PlanJump):
            solver: Solver = (task.jump.robot, task.jump.model)
            member.loaded[solver] = replace(task, near=None)
        if listening is not None:
            self._report(listening, message)

    def _keep_deadlines(self) -> None:
        now = time.monotonic()
        with self._lock:
            for member in self._workers:
                if member.working_on is not None:
                    self._keep_deadlines_of_job(member, member.working_on, now)
                if member.starting and now >= member.start_by:
                    self._note("a computing process was not ready in time")
                    member.end(now, unexpected=True)
            self._notify_waiting(now)
        for member in self._workers:
            ended = member.poll(now)
            if ended is not None and ended.unexpected:
                if ended.was_ready:
                    self._died(member, ended.how)
                else:
                    self._does_not_start(member, ended.how)

    def _keep_deadlines_of_job(self, member: WorkerProcess, entry: Entry, now: float) -> None:
        self._report_progress(member, entry, now)
        if member.stop_at is not None and now >= member.stop_at:
            member.ask_to_stop()
            member.stop_at = None
        silent = now >= member.silent_by
        if silent or (member.end_at is not None and now >= member.end_at):
            stuck = f"It gave no sign of life for {SILENCE / 60:g} minutes and was stopped."
            self._fail(member.finish(), stuck)
            member.plan_to_restore(but=None)
            member.end(now)

    def _report_progress(self, member: WorkerProcess, entry: Entry, now: float) -> None:
        """Report the newest progress, unless there was some a moment ago; it waits then."""
        if member.progress is not None and now >= member.notify_at:
            if member.wanted:
                self._report(entry, member.progress)
            member.progress, member.notify_at = None, now + PROGRESS_INTERVAL

    def _notify_waiting(self, now: float) -> None:
        busy = sorted(
            (
                (m.working_on, m.activity)
                for m in self._workers
                if m.working_on is not None and m.activity
            ),
            key=lambda pair: pair[0].job.number,
        )
        for entry in self._turns:
            if now < entry.notify_at:
                continue
            entry.notify_at = now + WAITING_INTERVAL
            # For its tab's own job if there is one, else for the one that takes longest.
            others = [activity for other, activity in busy if other.tab == entry.tab]
            others += [activity for _, activity in busy] or ["the computing process starts"]
            self._report(entry, Progress(entry.job.number, f"waiting: {others[0]}"))

    # ---- when something goes wrong

    def _died(self, member: WorkerProcess, how: str) -> None:
        """Fail its job; a new process takes its place."""
        message = f"The computing process ended unexpectedly ({how}) and was restarted."
        self._note(message)
        with self._lock:
            entry = member.working_on
            in_background = self._background.owns(entry)
            member.plan_to_restore(but=entry.job.task if entry and in_background else None)
            self._fail(member.finish(), message)

    def _does_not_start(self, member: WorkerProcess, how: str) -> None:
        """Not again before the next request, so that a lasting defect does not spin.

        If no process can start, all jobs that wait fail.
        """
        message = f"The computing process does not start ({how}); the terminal says why."
        self._note(message)
        with self._lock:
            member.may_start = False
            member.todo.clear()
            if not any(other.exists for other in self._workers):
                for entry in self._turns.clear():
                    self._fail(entry, message)
                self._fail_warm_up(message)

    def _recover(self, error: Exception) -> bool:
        """Fail all jobs and replace all processes; False if that did not help the last time."""
        now = time.monotonic()
        repeated = self._failed_at is not None and now - self._failed_at < REPEATED_FAILURE
        self._failed_at = now
        self._note("a defect in the pool of computing processes", error=error)
        message = BROKEN if repeated else DEFECT
        with self._lock:
            if repeated:
                self._refusal = self._refusal or BROKEN
            self._fail_all(message)
            for member in self._workers:
                member.plan_to_restore(but=None)
                member.end(now)
            if repeated:
                self._fail_warm_up(message)
        return not repeated

    def _fail(self, entry: Entry | None, message: str) -> None:
        """Report it to the job's tab, if there is one that waits; under the lock."""
        if entry is not None:
            self._report(entry, Failed(entry.job.number, message))

    def _fail_all(self, message: str) -> None:
        for member in self._workers:
            self._fail(member.finish(), message)
        for entry in self._turns.clear():
            self._fail(entry, message)

    def _fail_warm_up(self, message: str) -> None:
        if self._background.awaited:
            self._asides.put(partial(self._background.listener, Failed(0, message)))

    def _note(self, text: str, *values: object, error: Exception | None = None) -> None:
        """Log it, without waiting for a terminal that is not read."""
        self._asides.put(partial(_log.error, text, *values, exc_info=error))

    def _end_all(self) -> None:
        """End every process; what waits is told."""
        with self._lock:
            self._fail_all(self._refusal or CLOSED)
        for member in self._workers:
            member.end(time.monotonic())
        while any(member.ending for member in self._workers):
            time.sleep(POLL_INTERVAL)
            for member in self._workers:
                member.poll(time.monotonic())


def _ignore(_report: Report) -> None:
    """The listener of a tab that has gone."""
