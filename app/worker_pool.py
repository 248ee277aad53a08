"""The server's side of the computing process: who is next, who is told, and what if it dies.

Many tabs share one process. A tab has at most one job waiting: a newer one takes its place in the
queue, so that a slider dragged in one tab cannot starve another. A job that is running when its
tab asks for something newer may finish, because a solve is shorter than the patience of the eye;
if it takes long it is stopped. A simulation is stopped at once: its plan is no longer wanted.
"""

from __future__ import annotations

import ctypes
import itertools
import logging
import multiprocessing
import threading
import time
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Any

from app import worker
from app.protocol import (
    Cancelled,
    Failed,
    Job,
    PlannerFactory,
    Progress,
    Ready,
    Report,
    SimulateJump,
    Task,
)

Listener = Callable[[Report], None]

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class _Entry:
    tab: Hashable
    job: Job
    listener: Listener


class WorkerPool:
    """Owns the computing process and passes it the jobs of all tabs, one at a time.

    Listeners are called from one thread of this object, in order; they must return at once.
    """

    def __init__(
        self,
        factory: PlannerFactory = worker.LibraryPlanner,
        *,
        cancel_grace: float = 0.2,
        superseded_grace: float = 1.0,
    ) -> None:
        """Start the process.

        Args:
            factory: makes the planner inside the process.
            cancel_grace: how long a cancelled job may go on before its process is ended, s.
            superseded_grace: how long a plan may go on when its tab wants something newer, before
                it is asked to stop, s.
        """
        # Never fork: the child would inherit the server's sockets and threads' locks.
        self._context = multiprocessing.get_context("spawn")
        self._factory = factory
        self._cancel_grace = cancel_grace
        self._superseded_grace = superseded_grace
        self._cancelled_up_to: Any = self._context.Value(ctypes.c_longlong, 0, lock=False)
        self._numbers = itertools.count(1)

        # Under the lock: what tabs want. Everything else belongs to the thread alone.
        self._lock = threading.Lock()
        self._waiting: dict[Hashable, _Entry] = {}
        self._running: _Entry | None = None
        self._abandoned = False  # nobody waits for the running job any more
        self._doing = ""  # what the running job last told
        self._told = 0  # the newest waiting job that was told it
        self._stop_at: float | None = None  # when to ask the running job to stop
        self._end_at: float | None = None  # when to end the process
        self._closed = False
        self._start_wanted = True

        self._process: SpawnProcess | None = None
        self._process_id: int | None = None
        self._connection: Connection | None = None
        self._ready = False
        self._wake_reader, self._wake_writer = self._context.Pipe(duplex=False)
        self._thread = threading.Thread(target=self._run, name="worker-pool", daemon=True)
        self._thread.start()

    # ---- called by tabs, from any thread

    def submit(self, tab: Hashable, task: Task, listener: Listener) -> int:
        """Queue a task, in place of the tab's waiting one if there is one.

        The replaced one gets no report; the running one still does.

        Args:
            tab: who asks.
            task: what for.
            listener: called with `Progress` while waiting, then once with the outcome.

        Returns:
            The job's number, larger than that of all jobs before.
        """
        with self._lock:
            number = next(self._numbers)
            self._waiting[tab] = _Entry(tab, Job(number, task), listener)
            self._start_wanted = True
            if self._running is not None and self._running.tab == tab and self._stop_at is None:
                simulating = isinstance(self._running.job.task, SimulateJump)
                grace = 0.0 if simulating else self._superseded_grace
                self._stop_at = time.monotonic() + grace
            self._wake()
        return number

    def cancel(self, tab: Hashable) -> None:
        """Give up the tab's jobs, waiting and running; it hears `Cancelled` of each at once."""
        self._give_up(tab, tell=True)

    def forget(self, tab: Hashable) -> None:
        """Give up the tab's jobs without telling it: the tab has gone."""
        self._give_up(tab, tell=False)

    def close(self) -> None:
        """End the process and this object's thread."""
        with self._lock:
            self._closed = True
            self._wake()
        self._thread.join()

    @property
    def process_id(self) -> int | None:
        """Of the computing process, or None while there is none."""
        return self._process_id

    def _give_up(self, tab: Hashable, *, tell: bool) -> None:
        with self._lock:
            entries = [self._waiting.pop(tab)] if tab in self._waiting else []
            if self._running is not None and self._running.tab == tab and not self._abandoned:
                entries.insert(0, self._running)
                self._abandoned = True
                self._cancelled_up_to.value = self._running.job.number
                if tell:
                    self._end_at = time.monotonic() + self._cancel_grace
            self._wake()
        if tell:
            for entry in entries:
                entry.listener(Cancelled(entry.job.number))

    def _wake(self) -> None:
        if not self._wake_writer.closed:
            self._wake_writer.send_bytes(b"w")

    # ---- the thread

    def _run(self) -> None:
        while not self._closed:
            if self._process is None and self._start_wanted:
                self._start()
            self._send_next()
            self._wait_and_read()
            self._keep_deadlines()
        self._end_process()
        with self._lock:
            self._wake_writer.close()
            self._wake_reader.close()

    def _start(self) -> None:
        ours, theirs = self._context.Pipe()
        self._process = self._context.Process(
            target=worker.main,
            args=(theirs, self._cancelled_up_to, self._factory),
            name="llsrbm-planning",
            daemon=True,
        )
        self._process.start()
        self._process_id = self._process.pid
        # Only the child may hold its end, or its death would go unnoticed.
        theirs.close()
        self._connection = ours
        self._ready = False

    def _send_next(self) -> None:
        if not self._ready or self._connection is None:
            return
        with self._lock:
            if self._running is not None or not self._waiting:
                return
            # Insertion order is the order of asking: tabs take turns.
            entry = self._waiting.pop(next(iter(self._waiting)))
            self._running, self._doing = entry, ""
            self._abandoned = False
            self._stop_at = self._end_at = None
        try:
            self._connection.send(entry.job)
        except (BrokenPipeError, ConnectionResetError):
            self._died()

    def _wait_and_read(self) -> None:
        with self._lock:
            deadlines = [at for at in (self._stop_at, self._end_at) if at is not None]
        timeout = max(0.0, min(deadlines) - time.monotonic()) if deadlines else None
        connections = [c for c in (self._wake_reader, self._connection) if c is not None]
        for readable in wait(connections, timeout):
            if readable is self._wake_reader:
                self._wake_reader.recv_bytes()
                self._tell_newcomers()
                continue
            assert self._connection is not None
            try:
                message = self._connection.recv()
            except (EOFError, ConnectionResetError):
                self._died()
            else:
                self._receive(message)

    def _receive(self, message: Ready | Report) -> None:
        if isinstance(message, Ready):
            self._ready = True
            return
        with self._lock:
            running, abandoned = self._running, self._abandoned
            if isinstance(message, Progress):
                self._doing, self._told = message.text, 0
            else:
                self._running = None
                self._stop_at = self._end_at = None
        assert running is not None
        if not abandoned:
            running.listener(message)
        self._tell_newcomers()

    def _tell_newcomers(self) -> None:
        """Whoever waits in the queue waits for what is being done now."""
        with self._lock:
            text = self._doing if self._running is not None else ""
            entries = [e for e in self._waiting.values() if e.job.number > self._told]
            self._told = max([self._told, *(e.job.number for e in entries)])
        if text:
            for entry in entries:
                entry.listener(Progress(entry.job.number, text))

    def _keep_deadlines(self) -> None:
        with self._lock:
            now = time.monotonic()
            if self._stop_at is not None and now >= self._stop_at:
                assert self._running is not None
                self._cancelled_up_to.value = self._running.job.number
                self._stop_at = None
            overdue = self._end_at is not None and now >= self._end_at
            if overdue:
                self._running = None
                self._stop_at = self._end_at = None
        if overdue:
            self._end_process()

    def _died(self) -> None:
        """Tell whoever waited for the running job; a process that cannot even start, everybody."""
        started = self._ready
        exit_code = self._end_process(patience=1.0)
        how = f"signal {-exit_code}" if exit_code < 0 else f"exit status {exit_code}"
        with self._lock:
            running, self._running = self._running, None
            abandoned = self._abandoned
            self._stop_at = self._end_at = None
            victims = [running] if running is not None and not abandoned else []
            if started:
                message = f"The computing process ended unexpectedly ({how}) and was restarted."
            else:
                message = f"The computing process does not start ({how}); the terminal says why."
                victims += self._waiting.values()
                self._waiting.clear()
                # Not again before somebody asks, so that a lasting defect does not spin.
                self._start_wanted = False
        _log.error(message)
        for entry in victims:
            entry.listener(Failed(entry.job.number, message))

    def _end_process(self, patience: float = 0.0) -> int:
        """Close the connection and end the process, at once or when it has had time to exit."""
        process, connection = self._process, self._connection
        self._process = self._process_id = self._connection = None
        self._ready = False
        if connection is not None:
            connection.close()
        if process is None:
            return 0
        process.join(patience)
        if process.is_alive():
            process.terminate()
            process.join(1.0)
        if process.is_alive():
            process.kill()
            process.join()
        exit_code = process.exitcode or 0
        process.close()
        return exit_code
