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

import logging
import os
import threading
import time
from collections.abc import Callable, Hashable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from app.workers import worker
from app.workers.jobs import WAITING_INTERVAL, Jobs, ignore
from app.workers.member import Entry, Member
from app.workers.process import Ended, LocalProcess
from app.workers.reports import Cancelled, Failed, Listener
from app.workers.seeds import Seeds
from app.workers.tasks import PlanJump, PlannerFactory, Prepare, SimulateSeeds, Task
from app.workers.waiting import MOST_WAITING
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
_DRAIN = 1.0  # s for reports that are under way when the pool closes

CLOSED = "The server is closing."
BUSY = f"The server is busy: {MOST_WAITING} requests are waiting. Please try again in a moment."
_log = logging.getLogger(__name__)


class WorkerPool(Jobs):
    """Owns the computing processes and passes them the jobs of all tabs.

    A listener gets its job's reports in order, nothing after the outcome, from a thread of the
    pool's; it must return at once.
    """

    def __init__(
        self,
        factory: PlannerFactory = worker.LibraryPlanner,  # makes the planner inside a process
        *,
        # how many of this machine; with more than one, the last takes nothing that lasts seconds
        processes: int = PROCESSES,
        # how long a cancelled job may go on before its process is killed, s
        cancel_grace: float = CANCEL_GRACE,
        # how long a patient plan may go on when its tab wants something newer, before it has to
        # stop, s
        superseded_grace: float = SUPERSEDED_GRACE,
        # whose processes compute too, as many as it offers at the time; closed with the pool
        cluster: Cluster | None = None,
    ) -> None:
        self.planner = f"{factory.__module__}.{factory.__qualname__}"  # name of the planner
        # called with a line when something has happened to the cluster; may take its time
        self.remarked: Callable[[str], object] = ignore
        self._superseded_grace = superseded_grace
        self._cluster = cluster
        members = [
            Member(
                LocalProcess(factory, f"llsrbm-computing-{i + 1}"),
                reserved=0 < i == processes - 1,
            )
            for i in range(processes)
        ]
        if cluster is not None:
            members += [
                Member(process, reserved=(processes + i) % RESERVED_EVERY == 1, remote=True)
                for i, process in enumerate(cluster.processes(factory, MOST_ON_CLUSTER))
            ]
        super().__init__(members, cancel_grace)
        self._threads: set[threading.Thread] = set()
        self._start_thread(self._keep_time, "worker-pool-clock")
        self._wake()
        if cluster is not None:
            cluster.watch(self._wake, self._remark)

    # ---- called by tabs, from any thread

    def submit(self, tab: Hashable, task: Task, listener: Listener) -> int:
        """Queue a task in place of the tab's waiting one; the job's number, larger than all before.

        The replaced one gets no report; a running one still does. A request that cannot be taken,
        because too many wait or the pool has ended, is answered with `Failed` before this returns.
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
                entry.listener, entry.over = ignore, True  # for reports that are under way

    def warm_up(
        self, tasks: Sequence[Prepare | PlanJump], listener: Listener, done: Callable[[], None]
    ) -> None:
        """Have every process load what is likely to be requested; called once.

        Robots are prepared by the first process only, as that is for all. `listener` gets its
        reports, `done` is called when it is through; both may take their time.
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
        return tuple(member.process.id for member in self._workers)

    # ---- a process' thread

    def _start_thread(self, target: Callable[[], None], name: str) -> None:
        def run() -> None:
            target()
            self._threads.discard(threading.current_thread())

        thread = threading.Thread(target=run, name=name, daemon=True)
        self._threads.add(thread)
        thread.start()

    def _run(self, member: Member) -> None:
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

    def _shall_start(self, member: Member) -> bool:
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

    def _ended(self, member: Member, ended: Ended) -> None:
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

    def _wake(self) -> None:
        with self._lock:
            self._hand_out()

    def _remark(self, remark: str) -> None:
        self._note("%s", remark)
        self._asides.put(lambda: self.remarked(remark))
