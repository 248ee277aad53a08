"""The server's hold on one computing process: started, given jobs, asked to stop, ended."""

from __future__ import annotations

import ctypes
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any

from app.compute import worker
from app.compute.protocol import Job, PlannerFactory, Progress, Task
from app.compute.scheduler import Entry, Member

# How long a process may take to exit by itself once its connection is closed, and to be gone once
# it is told to, s. The latter is never used up unless the machine is stuck.
EXIT_PATIENCE, END_PATIENCE = 1.0, 1.0


class WorkerProcess(Member):
    """One computing process, which may come and go, and what is going on there.

    Attributes:
        id: of the process; None while there is none.
        connection: to it; None while there is none.
        may_start: False once it could not, until somebody asks for something.
        wanted: whether somebody still waits for its job.
        todo: what to load when there is nothing else to do.
        stop_at, end_at: when to ask the running job to stop, and to end the process, s.
        doing: what the running job told last.
        news: what it told and its tab has not heard yet.
        news_at: when the tab may hear the next, s.
    """

    def __init__(
        self, context: SpawnContext, factory: PlannerFactory, number: int, *, reserved: bool
    ) -> None:
        """Nothing runs before `start`.

        Args:
            context: spawns; a forked child would inherit the server's sockets and threads' locks.
            factory: makes the planner inside the process.
            number: for its name.
            reserved: takes nothing that lasts seconds.
        """
        super().__init__(reserved)
        self._context = context
        self._factory = factory
        self._name = f"llsrbm-computing-{number}"
        self._stop: Any = context.Value(ctypes.c_longlong, 0, lock=False)
        self._process: SpawnProcess | None = None
        self.id: int | None = None
        self.connection: Connection | None = None
        self.may_start = True
        self.wanted = True
        self.todo: list[Task] = []
        self.stop_at: float | None = None
        self.end_at: float | None = None
        self.doing = ""
        self.news: Progress | None = None
        self.news_at = 0.0

    # ---- the process

    def start(self) -> None:
        """Start it; it says `Ready` when it can take a job."""
        ours, theirs = self._context.Pipe()
        self._process = self._context.Process(
            target=worker.main,
            args=(theirs, self._stop, self._factory),
            name=self._name,
            daemon=True,
        )
        self._process.start()
        self.id = self._process.pid
        # Only the child may hold its end, or its death would go unnoticed.
        theirs.close()
        self.connection = ours

    def send(self, job: Job) -> bool:
        """Give it a job; False if it is no more."""
        assert self.connection is not None
        try:
            self.connection.send(job)
        except (BrokenPipeError, ConnectionResetError):
            return False
        return True

    def ask_to_stop(self) -> None:
        """Its job needs no result any more; from any thread."""
        if self.working_on is not None:
            self.stopping = True
            self._stop.value = self.working_on.job.number

    def end(self, patience: float = 0.0) -> str:
        """End it at once, or when it has had time to exit by itself; says how it ended."""
        process, connection = self._process, self.connection
        self._process = self.id = self.connection = None
        self.ready = False
        if connection is not None:
            connection.close()
        if process is None:
            return "not started"
        process.join(patience)
        if process.is_alive():
            process.terminate()
            process.join(END_PATIENCE)
        if process.is_alive():
            process.kill()
            process.join()
        exit_code = process.exitcode or 0
        process.close()
        return f"signal {-exit_code}" if exit_code < 0 else f"exit status {exit_code}"

    # ---- its job

    def begin(self, entry: Entry) -> None:
        """Have that job now."""
        self.working_on, self.wanted, self.stopping = entry, True, False
        self.doing, self.news, self.news_at = "", None, 0.0
        self.stop_at = self.end_at = None

    def finish(self) -> Entry | None:
        """Have none; the one it had, if somebody waits for it."""
        entry, self.working_on = self.working_on, None
        self.stop_at = self.end_at = self.news = None
        return entry if self.wanted else None

    def plan_to_restore(self, but: Task | None) -> None:
        """What a new process in its place has to load: all but what ended the old one."""
        tasks: list[Task] = [*self.loaded.values(), *self.todo]
        self.todo = [task for task in tasks if task != but]
        self.loaded.clear()
