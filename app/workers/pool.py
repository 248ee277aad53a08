"""The pool of computing processes, as tabs see it: submit, cancel, forget.

The order of jobs is decided in `app.workers.scheduler`; `app.workers.dispatcher` passes them on. A
plan that is running when its tab requests something newer may finish if it is a quick one, because
that is shorter than one notices; if it takes longer it is stopped. A simulation or a search is
stopped at once: it is no longer wanted.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import queue
import threading
import time
from collections.abc import Callable, Hashable, Sequence
from typing import TYPE_CHECKING

from app.workers import worker
from app.workers.channel import Inbox
from app.workers.dispatcher import Dispatcher
from app.workers.jobs import WAITING_INTERVAL, Jobs
from app.workers.member import PoolMember
from app.workers.planner import PlannerFactory
from app.workers.process import LocalProcess
from app.workers.protocol import Cancelled, Failed, Job, PlanJump, Prepare, Report, Task
from app.workers.scheduler import MOST_WAITING, Entry, Listener

if TYPE_CHECKING:
    from app.workers.cluster import Cluster

# One process plans while another simulates; more than four would mostly cost memory (0.3 GB each).
PROCESSES = min(max(os.cpu_count() or 1, 2), 4)
# Of this machine: beyond that the pool's one thread would be what they wait for. And of a cluster.
MOST_PROCESSES = 64
MOST_ON_CLUSTER = 64
# Of a cluster's processes every other one takes nothing that lasts seconds: who drags notices each
# tenth, who simulates waits anyway. Figures: docs/page-on-a-cluster.md.
RESERVED_EVERY = 2
# How long a cancelled job may go on before its process is ended, s: the rest of the 0.2 s that
# cancelling may take is for ending it.
CANCEL_GRACE = 0.15
# How long a patient plan may go on when its tab wants something newer, s: longer than most take.
SUPERSEDED_GRACE = 0.3
# How long the job of a tab that has gone may go on, s: a solver that is being built (half a minute)
# will be of use, a hung one never.
FORGOTTEN_GRACE = 60.0
# How long closing may take, s: processes that do not end are killed after a second of it.
CLOSE_PATIENCE = 5.0

CLOSED = "The server is closing."
BUSY = f"The server is busy: {MOST_WAITING} requests are waiting. Please try again in a moment."

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
            cancel_grace: how long a cancelled job may go on before its process is ended, s.
            superseded_grace: how long a patient plan may go on when its tab wants something newer,
                before it is asked to stop, s.
            cluster: whose processes compute too, as many as it offers at the time; closed with
                the pool.
        """
        self.planner = f"{factory.__module__}.{factory.__qualname__}"
        self.remarked: Callable[[str], object] = _ignore
        self._cancel_grace = cancel_grace
        self._superseded_grace = superseded_grace
        context = multiprocessing.get_context("spawn")
        self._inbox: Inbox = queue.SimpleQueue()
        members = [
            PoolMember(
                LocalProcess(context, factory, self._inbox, f"llsrbm-computing-{i + 1}"),
                reserved=0 < i == processes - 1,
            )
            for i in range(processes)
        ]
        if cluster is not None:
            members += [
                PoolMember(process, reserved=(processes + i) % RESERVED_EVERY == 1, remote=True)
                for i, process in enumerate(
                    cluster.processes(factory, self._inbox, MOST_ON_CLUSTER)
                )
            ]
        self._cluster = cluster
        self._workers = tuple(members)
        self._jobs = Jobs(self._workers)
        self._dispatcher = Dispatcher(self._jobs, self._inbox)
        self._thread = threading.Thread(
            target=self._dispatcher.run, name="worker-pool", daemon=True
        )
        self._thread.start()
        if cluster is not None:
            cluster.watch(self._wake, self._note)

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
        with self._jobs.lock:
            number = self._jobs.number()
            refusal = self._jobs.refusal or (BUSY if self._jobs.turns.is_full_for(tab) else "")
            if not refusal:
                self._jobs.turns.put(
                    Entry(tab, Job(number, task), listener, now + WAITING_INTERVAL)
                )
                for member in self._workers:
                    member.may_start = True
                    self._jobs.supersede(member, tab, task, now, self._superseded_grace)
        if refusal:
            listener(Failed(number, refusal))
        else:
            self._wake()
        return number

    def cancel(self, tab: Hashable) -> None:
        """Give up the tab's jobs, waiting and running; each is `Cancelled` at once."""
        with self._jobs.lock:
            for entry in self._give_up(tab, self._cancel_grace):
                self._jobs.report(entry, Cancelled(entry.job.number))

    def forget(self, tab: Hashable) -> None:
        """Give up the tab's jobs without a report: the tab has gone."""
        with self._jobs.lock:
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
        with self._jobs.lock:
            self._jobs.background.warm_up(tasks, listener, done)
        self._wake()

    def close(self) -> None:
        """End the processes and this object's threads, within `CLOSE_PATIENCE` or little more."""
        with self._jobs.lock:
            self._jobs.refusal = self._jobs.refusal or CLOSED
            self._jobs.closed = True
        self._wake()
        self._thread.join(CLOSE_PATIENCE)
        if self._thread.is_alive():
            _log.error("the pool's thread does not end; its processes are killed")
            for member in self._workers:
                member.process.kill()
        if self._cluster is not None:
            self._cluster.close()
        self._jobs.close()

    @property
    def process_ids(self) -> tuple[int | None, ...]:
        """Of each computing process, None while there is none; the reserved one is the last."""
        return tuple(member.id for member in self._workers)

    def _give_up(self, tab: Hashable, grace: float) -> list[Entry]:
        entries = self._jobs.give_up(tab, grace)
        self._wake()
        return entries

    def _wake(self) -> None:
        self._inbox.put(None)

    def _note(self, remark: str) -> None:
        self._jobs.note("%s", remark)
        self._jobs.put_aside(lambda: self.remarked(remark))


def _ignore(_report: Report | str) -> None:
    """The listener of a tab that has gone, or of a pool without a page."""
