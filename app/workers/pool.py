"""The pool of computing processes, as tabs see it: submit, cancel, forget.

The order of jobs is decided in `app.workers.waiting`. A plan that is running when its tab requests
something newer may finish if it is a quick one, because that is shorter than one notices; if it
takes longer it is stopped. A simulation or a search is stopped at once: it is no longer wanted.

All state is changed under one lock, which is never held for long. Each process has a thread, which
starts it and reads its messages; one more, the clock, keeps deadlines. Listeners are called
outside the lock, by two threads, in the order in which the reports came about: one calls those of
tabs; the other calls the warm-up's and writes the log, whose terminal may not be read by anybody.
"""

from __future__ import annotations

import itertools
import logging
import os
import threading
import time
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from app.workers import worker
from app.workers.deliveries import Deliveries
from app.workers.member import SILENCE, PoolMember
from app.workers.process import Ended, LocalProcess
from app.workers.protocol import (
    Cancelled,
    Failed,
    Listener,
    Partial,
    PlanJump,
    Planned,
    PlannerFactory,
    Prepare,
    Progress,
    Ready,
    Report,
    SimulatedSoFar,
    SimulateJump,
    SimulateSeeds,
    Task,
)
from app.workers.seeds import Seeds
from app.workers.waiting import MOST_WAITING, Entry, Waiting
from llsrbm.errors import InputError

if TYPE_CHECKING:
    from app.workers.cluster import Cluster

# One process plans while another simulates; more than four would mostly cost memory (0.3 GB each).
PROCESSES = min(max(os.cpu_count() or 1, 2), 4)
MOST_PROCESSES = 64  # of this machine
MOST_ON_CLUSTER = 64
# Of a cluster's processes every other one takes nothing that lasts seconds: who drags notices each
# tenth, who simulates waits anyway. Figures: docs/page-on-a-cluster.md.
RESERVED_EVERY = 2
# How long a cancelled job may go on before its process is killed, s: the rest of the 0.2 s that
# cancelling may take is for that.
CANCEL_GRACE = 0.15
# How long a patient plan may go on when its tab wants something newer, s: longer than most take.
SUPERSEDED_GRACE = 0.3
# How long the job of a tab that has gone may go on, s: a solver that is being built (half a minute)
# will be of use, a hung one never.
FORGOTTEN_GRACE = 60.0
CLOSE_PATIENCE = 5.0  # s that closing may take
# A second unforeseen exception within this time of the first is a lasting defect, s: replacing the
# processes takes a second or two and did not help.
REPEATED_FAILURE = 10.0
PROGRESS_INTERVAL = 0.1  # least time between two pieces of progress of a job, s
# A tab that waits gets to know the reason after this time and then again and again, s.
WAITING_INTERVAL = 0.5
_DRAIN = 1.0  # s for reports that are under way when the pool closes

CLOSED = "The server is closing."
BUSY = f"The server is busy: {MOST_WAITING} requests are waiting. Please try again in a moment."
DEFECT = "A defect of the server interrupted this; please try again."
BROKEN = "The server has a lasting defect and computes nothing any more; the terminal says more."
SILENT = f"It gave no sign of life for {SILENCE / 60:g} minutes and was stopped."
LATE = "It took more than {limit:g} s and was stopped."

_log = logging.getLogger(__name__)


class WorkerPool:
    """Owns the computing processes and passes them the jobs of all tabs.

    A listener gets its job's reports in order, nothing after the outcome, from a thread of the
    pool's; it must return at once.

    Attributes:
        planner: name of the planner.
        remarked: called with a line when something has happened to the cluster; may take its time.
    """

    def __init__(
        self,
        factory: PlannerFactory = worker.LibraryPlanner,
        *,
        processes: int = PROCESSES,
        cancel_grace: float = CANCEL_GRACE,
        superseded_grace: float = SUPERSEDED_GRACE,
        cluster: Cluster | None = None,
    ) -> None:
        """Start the first process; the others follow when it has planned something.

        Args:
            factory: makes the planner inside a process.
            processes: how many of this machine; with more than one, the last takes nothing that
                lasts seconds.
            cancel_grace: how long a cancelled job may go on before its process is killed, s.
            superseded_grace: how long a patient plan may go on when its tab wants something newer,
                before it has to stop, s.
            cluster: whose processes compute too, as many as it offers at the time; closed with
                the pool.
        """
        self.planner = f"{factory.__module__}.{factory.__qualname__}"
        self.remarked: Callable[[str], object] = _ignore
        self._cancel_grace, self._superseded_grace = cancel_grace, superseded_grace
        self._cluster = cluster
        members = [
            PoolMember(
                LocalProcess(factory, f"llsrbm-computing-{i + 1}"),
                reserved=0 < i == processes - 1,
            )
            for i in range(processes)
        ]
        if cluster is not None:
            members += [
                PoolMember(process, reserved=(processes + i) % RESERVED_EVERY == 1, remote=True)
                for i, process in enumerate(cluster.processes(factory, MOST_ON_CLUSTER))
            ]
        self._workers = tuple(members)
        self._lock = threading.RLock()
        self._changed = threading.Condition(self._lock)
        self._waiting = Waiting()
        self._numbers = itertools.count(1)
        self._refusal = ""  # the answer to all requests; "" as long as they are taken
        self._failed_at: float | None = None  # time of the last unforeseen exception
        self._warm_up_listener: Listener = _ignore
        self._warm_up_done: Callable[[], None] | None = None
        self._reports, self._asides = Deliveries("reports"), Deliveries("asides")
        self._threads: set[threading.Thread] = set()
        self._start_thread(self._keep_time, "worker-pool-clock")
        self._wake()
        if cluster is not None:
            cluster.watch(self._wake, self._remark)

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
            refusal = self._refusal or (BUSY if self._waiting.is_full_for(tab) else "")
            try:
                batch = Seeds(number, task) if isinstance(task, SimulateSeeds) else None
            except InputError as error:
                refusal = refusal or str(error)
            if not refusal:
                entry = Entry(tab, number, task, listener, now + WAITING_INTERVAL, batch=batch)
                self._waiting.put(entry)
                for member in self._workers:
                    member.may_start = True
                    if member.working_on is not None and member.working_on.tab == tab:
                        member.supersede(task, now, self._superseded_grace)
                self._hand_out()
        if refusal:
            listener(Failed(number, refusal))
        return number

    def cancel(self, tab: Hashable) -> None:
        """Give up the tab's jobs, waiting and running; each is `Cancelled` at once."""
        with self._lock:
            for entry in self._give_up(tab, self._cancel_grace):
                self._report(entry, Cancelled(entry.number))

    def forget(self, tab: Hashable) -> None:
        """Give up the tab's jobs without a report: the tab has gone."""
        with self._lock:
            for entry in self._give_up(tab, FORGOTTEN_GRACE):
                entry.listener, entry.over = _ignore, True  # for reports that are under way

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
            self._warm_up_listener, self._warm_up_done = listener, done
            for member in self._workers:
                first = member is self._workers[0]
                member.todo += [task for task in tasks if first or not isinstance(task, Prepare)]
            self._hand_out()

    def close(self) -> None:
        """End the processes and this object's threads, within `CLOSE_PATIENCE` or little more."""
        with self._lock:
            self._refusal = self._refusal or CLOSED
            self._stop_all(self._refusal)
        end = time.monotonic() + CLOSE_PATIENCE
        for thread in tuple(self._threads):
            thread.join(max(0.0, end - time.monotonic()))
        if self._cluster is not None:
            self._cluster.close()
        self._reports.close(_DRAIN)
        self._asides.close(_DRAIN)

    @property
    def process_ids(self) -> tuple[int | None, ...]:
        """Of each computing process, None while there is none; the reserved one is the last."""
        return tuple(member.id for member in self._workers)

    # ---- a process' thread

    def _start_thread(self, target: Callable[[], None], name: str) -> None:
        def run() -> None:
            target()
            self._threads.discard(threading.current_thread())

        thread = threading.Thread(target=run, name=name, daemon=True)
        self._threads.add(thread)
        thread.start()

    def _run(self, member: PoolMember) -> None:
        """From the start of a process to its end."""
        try:
            for message in member.process.run():
                with self._lock:
                    self._receive(member, message)
        except Ended as ended:
            with self._lock:
                self._ended(member, ended)
        except Exception as error:  # noqa: BLE001  # the last resort: whatever it is
            with self._lock:
                member.running = member.ready = False
                self._recover(error)
                self._hand_out()

    def _start_processes(self) -> None:
        for number, member in enumerate(self._workers):
            if self._shall_start(member) and member.process.reserve():
                member.start(time.monotonic())
                self._start_thread(partial(self._run, member), f"worker-pool-{number}")

    def _shall_start(self, member: PoolMember) -> bool:
        if self._refusal or member.running or not member.may_start:
            return False
        first = self._workers[0]
        # On two cores the others would delay the first until it has something likely at hand.
        return (
            member is first
            or len(self._waiting) > 0
            or any(other.loaded for other in self._workers)
            or (self._warm_up_done is not None and not first.todo)
        )

    def _receive(self, member: PoolMember, message: Ready | Report) -> None:
        """Take a message of a process and report it to the job's tab."""
        if isinstance(message, Ready):
            member.ready = not member.ending
            self._hand_out()
            return
        entry, task = member.working_on, member.task
        if entry is None or task is None or entry.number != message.job or member.ending:
            return
        now = time.monotonic()
        member.silent_by = now + SILENCE
        if isinstance(message, Progress):
            member.activity, member.progress = message.text, message
            self._report_progress(member, entry, now)
            return
        if isinstance(message, SimulatedSoFar):
            self._report(entry, message, task)
            return
        member.finish()
        if not isinstance(message, Cancelled):
            self._waiting.note_done(task)
        if isinstance(message, Planned) and isinstance(task, PlanJump):
            member.loaded[task.needs] = replace(task, near=None)
        self._report(entry, message, task)
        self._cancel_remains(entry)
        self._hand_out()

    def _cancel_remains(self, entry: Entry) -> None:
        """Cancel a job whose last parts made way for a newer one, once the first have ended."""
        running = any(member.working_on is entry for member in self._workers)
        if not (entry.over or running or self._waiting.get(entry.tab) is entry):
            self._report(entry, Cancelled(entry.number))

    def _ended(self, member: PoolMember, ended: Ended) -> None:
        """A process has gone: fail its job; a new one takes its place, if there is a machine."""
        was_ready, expected = member.ready, member.ending
        member.running = member.ready = member.ending = False
        if self._refusal:
            return
        if was_ready or expected:
            entry, task = member.working_on, member.task
            loading = entry is not None and entry.tab is self
            member.plan_to_restore(but=task if loading else None)
            message = f"The computing process ended unexpectedly ({ended.how})"
            message += " and was restarted." if member.process.startable else "; please try again."
            if not expected and not ended.logged:
                self._note(message)
            if (left := member.finish()) is not None:
                self._report(left, Failed(left.number, message))
        else:
            # Not again before the next request, so that a lasting defect does not spin.
            message = f"The computing process does not start ({ended.how}); the terminal says why."
            if not ended.logged:
                self._note(message)
            member.may_start = False
            member.todo.clear()
            if not any(other.running for other in self._workers):
                self._fail_all(message)
                self._fail_warm_up(message)
        self._hand_out()

    # ---- the clock's thread

    def _keep_time(self) -> None:
        with self._changed:
            while not self._refusal:
                try:
                    due = self._keep_deadlines(time.monotonic())
                except Exception as error:  # noqa: BLE001  # the last resort: whatever it is
                    due = None
                    self._recover(error)
                self._changed.wait(None if due is None else max(0.0, due - time.monotonic()))

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

    def _keep_deadlines_of_job(self, member: PoolMember, entry: Entry, now: float) -> None:
        self._report_progress(member, entry, now)
        if member.stop_at is not None and now >= member.stop_at:
            member.request_stop()
            member.stop_at = None
            self._hand_out()  # what its tab wants instead
        late = member.end_at is not None and now >= member.end_at
        if late or now >= member.silent_by:
            limit = member.task.limit if member.task is not None else None
            message = LATE.format(limit=limit) if late and limit else SILENT
            self._report(entry, Failed(entry.number, message))
            member.finish()
            member.plan_to_restore(but=None)
            member.kill()

    def _report_progress(self, member: PoolMember, entry: Entry, now: float) -> None:
        """Report the newest progress, unless there was some a moment ago; it waits then."""
        if member.progress is not None and now >= member.notify_at:
            self._report(entry, member.progress, member.task)
            member.progress, member.notify_at = None, now + PROGRESS_INTERVAL
        elif member.progress is not None:
            self._changed.notify_all()

    def _notify_waiting(self, now: float) -> None:
        """Report the reason to the tabs that wait, those whose time has come."""
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
            self._report(entry, Progress(entry.number, f"waiting: {others[0]}", waiting=True))

    # ---- under the lock

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

    def _next_to_load(self) -> tuple[Entry, Task, PoolMember] | None:
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
                    listener = self._warm_up_listener if reported else _ignore
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

    def _report(self, entry: Entry, report: Report, task: Task | None = None) -> None:
        """Have the listener called, soon; the lock keeps the order of reports.

        Args:
            entry: the job.
            report: on it, or on one of its parts.
            task: that part.
        """
        reports = [report]
        if entry.batch is not None and isinstance(task, SimulateJump):
            reports = entry.batch.take(task, report)
        for each in reports:
            if entry.over:
                return
            if not isinstance(each, Partial):
                entry.over = True
                self._stop_parts(entry)
            calls = self._asides if entry.tab is self else self._reports
            calls.put(partial(_deliver, entry, each))

    def _stop_parts(self, entry: Entry) -> None:
        """Have what is left of a job end, now that it has its outcome."""
        if entry.parts and self._waiting.get(entry.tab) is entry:
            self._waiting.withdraw(entry.tab)
        for member in self._workers:
            if member.working_on is entry and not member.stopping:
                member.request_stop()
                member.end_at = time.monotonic() + self._cancel_grace

    def _fail_all(self, message: str) -> None:
        """Fail all jobs that a tab waits for."""
        for entry in self._waiting.clear():
            self._report(entry, Failed(entry.number, message))
        for member in self._workers:
            left = member.finish()
            if left is not None and left.tab is not self:
                self._report(left, Failed(left.number, message))

    def _fail_warm_up(self, message: str) -> None:
        """Report it to the listener of the warm-up, if the first process is not through."""
        if self._warm_up_done is not None:
            self._asides.put(partial(self._warm_up_listener, Failed(0, message)))

    def _unsendable(self, member: PoolMember, entry: Entry, error: Exception) -> None:
        """A task cannot be pickled."""
        with self._lock:
            self._note("job %d cannot be sent", entry.number, error=error)
            if member.working_on is entry:
                member.finish()
            self._report(entry, Failed(entry.number, DEFECT))
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

    def _wake(self) -> None:
        with self._lock:
            self._hand_out()

    def _note(self, text: str, *values: object, error: Exception | None = None) -> None:
        """Log it, without waiting for a terminal that is not read."""
        self._asides.put(partial(_log.error, text, *values, exc_info=error))

    def _remark(self, remark: str) -> None:
        self._note("%s", remark)
        self._asides.put(lambda: self.remarked(remark))


def _deliver(entry: Entry, report: Report) -> None:
    """Call the listener that the entry has now: a tab that goes meanwhile gets nothing any more."""
    entry.listener(report)


def _ignore(_report: Report | str) -> None:
    """Take nothing: of a tab that has gone, of loading, or of a pool without a page."""
