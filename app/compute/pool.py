"""The pool of computing processes: who is told what, who has to stop, and what if one dies.

Whose job is next is decided in `app.compute.scheduler`. A plan that is running when its tab asks
for something
newer may finish if it is a quick one, because that is shorter than the patience of the eye; if it
takes longer it is stopped. A simulation or a search is stopped at once: it is no longer wanted.
"""

from __future__ import annotations

import itertools
import logging
import multiprocessing
import os
import threading
import time
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from multiprocessing.connection import wait
from typing import Any

from app.compute import worker
from app.compute.process import EXIT_PATIENCE, WorkerProcess
from app.compute.protocol import (
    Cancelled,
    Failed,
    Job,
    PlanJump,
    Planned,
    PlannerFactory,
    Prepare,
    Progress,
    Ready,
    Report,
    Task,
)
from app.compute.scheduler import Entry, Kind, Listener, Scheduler, Solver
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
NEWS_INTERVAL = 0.1
# Who waits is told what for, after this time and then again and again, s.
WAITING_INTERVAL = 0.5

_log = logging.getLogger(__name__)


class WorkerPool:
    """Owns the computing processes and passes them the jobs of all tabs.

    A listener hears its job's reports in order, nothing after the outcome; it must return at once.

    Attributes:
        planner: name of what computes.
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

        # Under the lock: what tabs want, and who works on what. The rest is the thread's alone.
        self._lock = threading.RLock()  # listeners are called under it
        self._turns = Scheduler()
        self._workers = [
            WorkerProcess(context, factory, i + 1, reserved=0 < i == processes - 1)
            for i in range(processes)
        ]
        self._background = Background(self._workers, self._turns)
        self._closed = False

        self._wake_reader, self._wake_writer = context.Pipe(duplex=False)
        self._thread = threading.Thread(target=self._run, name="worker-pool", daemon=True)
        self._thread.start()

    # ---- called by tabs, from any thread

    def submit(self, tab: Hashable, task: Task, listener: Listener) -> int:
        """Queue a task, in place of the tab's waiting one if there is one.

        The replaced one gets no report; a running one still does.

        Args:
            tab: who asks.
            task: what for.
            listener: called with `Progress` while waiting, then once with the outcome.

        Returns:
            The job's number, larger than that of all jobs before.
        """
        now = time.monotonic()
        with self._lock:
            number = next(self._numbers)
            self._turns.put(Entry(tab, Job(number, task), listener, now + WAITING_INTERVAL))
            for member in self._workers:
                member.may_start = True
                self._supersede(member, tab, task, now)
            self._wake()
        return number

    def cancel(self, tab: Hashable) -> None:
        """Give up the tab's jobs, waiting and running; it hears `Cancelled` of each at once."""
        with self._lock:
            for entry in self._give_up(tab, self._cancel_grace):
                entry.tell(Cancelled(entry.job.number))

    def forget(self, tab: Hashable) -> None:
        """Give up the tab's jobs without telling it: the tab has gone."""
        self._give_up(tab, FORGOTTEN_GRACE)

    def warm_up(
        self, tasks: Sequence[Prepare | PlanJump], listener: Listener, done: Callable[[], None]
    ) -> None:
        """Have every process load what is likely to be asked for, while nobody asks; called once.

        Args:
            tasks: in order; robots are prepared by the first process only, as that is for all.
            listener: hears the reports of the first process.
            done: called when the first process is through; the others go on.
        """
        with self._lock:
            self._background.warm_up(tasks, listener, done)
            self._wake()

    def close(self) -> None:
        """End the processes and this object's thread."""
        with self._lock:
            self._closed = True
            self._wake()
        self._thread.join()

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
            # The hand that rested has moved on, and what it asks for is not to wait.
            member.stop_at = now
        elif patient:
            member.stop_at = now + self._superseded_grace

    def _give_up(self, tab: Hashable, grace: float) -> list[Entry]:
        with self._lock:
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
        if not self._wake_writer.closed:
            self._wake_writer.send_bytes(b"w")

    # ---- the thread

    def _run(self) -> None:
        while not self._closed:
            self._hand_out()
            self._start()
            self._wait_and_read()
            self._keep_deadlines()
        for member in self._workers:
            member.end()
        with self._lock:
            self._wake_writer.close()
            self._wake_reader.close()

    def _hand_out(self) -> None:
        while True:
            with self._lock:
                turn = self._next()
                if turn is None:
                    break
                entry, member = turn
                member.begin(entry)
            if not member.send(entry.job):
                self._died(member)
        self._background.look_whether_done()

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
            if member.connection is None and member.may_start and (more or member is first):
                member.start()

    def _wait_and_read(self) -> None:
        due = self._next_deadline()
        timeout = None if due is None else max(0.0, due - time.monotonic())
        members = {m.connection: m for m in self._workers if m.connection is not None}
        readable: list[Any] = wait([self._wake_reader, *members], timeout)
        for connection in readable:
            if connection is self._wake_reader:
                self._wake_reader.recv_bytes()
                continue
            try:
                message = connection.recv()
            except (EOFError, ConnectionResetError):
                self._died(members[connection])
            else:
                with self._lock:
                    self._receive(members[connection], message)

    def _next_deadline(self) -> float | None:
        with self._lock:
            due = [at for m in self._workers for at in (m.stop_at, m.end_at) if at is not None]
            due += [m.news_at for m in self._workers if m.news is not None]
            due += [entry.tell_at for entry in self._turns]
        return min(due, default=None)

    def _receive(self, member: WorkerProcess, message: Ready | Report) -> None:
        if isinstance(message, Ready):
            member.ready = True
            return
        if isinstance(message, Progress):
            member.doing, member.news = message.text, message
            return
        assert member.working_on is not None
        task = member.working_on.job.task
        listening = member.finish()
        if not isinstance(message, Cancelled):
            self._turns.note_done(task)
        if isinstance(message, Planned) and isinstance(task, PlanJump):
            solver: Solver = (task.jump.robot, task.jump.model)
            member.loaded[solver] = replace(task, near=None)
        if listening is not None:
            listening.tell(message)

    def _keep_deadlines(self) -> None:
        now = time.monotonic()
        overdue = []
        with self._lock:
            for member in self._workers:
                if member.working_on is None:
                    continue
                if member.news is not None and now >= member.news_at:
                    if member.wanted:
                        member.working_on.tell(member.news)
                    member.news, member.news_at = None, now + NEWS_INTERVAL
                if member.stop_at is not None and now >= member.stop_at:
                    member.ask_to_stop()
                    member.stop_at = None
                if member.end_at is not None and now >= member.end_at:
                    member.finish()
                    member.plan_to_restore(but=None)
                    overdue.append(member)
            self._tell_who_waits(now)
        for member in overdue:
            member.end()

    def _tell_who_waits(self, now: float) -> None:
        busy = sorted(
            (
                (m.working_on, m.doing)
                for m in self._workers
                if m.working_on is not None and m.doing
            ),
            key=lambda pair: pair[0].job.number,
        )
        for entry in self._turns:
            if now < entry.tell_at:
                continue
            entry.tell_at = now + WAITING_INTERVAL
            # For its tab's own job if there is one, else for the one that takes longest.
            others = [doing for other, doing in busy if other.tab == entry.tab]
            others += [doing for _, doing in busy] or ["the computing process starts"]
            entry.tell(Progress(entry.job.number, f"waiting: {others[0]}"))

    def _died(self, member: WorkerProcess) -> None:
        """Tell whoever waited for its job; if no process can even start, everybody."""
        started = member.ready
        how = member.end(EXIT_PATIENCE)
        if started:
            message = f"The computing process ended unexpectedly ({how}) and was restarted."
        else:
            message = f"The computing process does not start ({how}); the terminal says why."
        _log.error(message)
        with self._lock:
            entry, victim = member.working_on, member.finish()
            victims = [] if victim is None else [victim]
            in_background = self._background.owns(entry)
            member.plan_to_restore(but=entry.job.task if entry and in_background else None)
            if not started:
                # Not again before somebody asks, so that a lasting defect does not spin.
                member.may_start = False
                member.todo.clear()
                if not any(m.connection for m in self._workers):
                    victims += self._turns.clear()
                    self._background.fail(message)
            for entry in victims:
                entry.tell(Failed(entry.job.number, message))
