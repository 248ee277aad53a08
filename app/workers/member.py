"""One place of the pool: a computing process, which may come and go, and its job.

Where the process runs is its own affair (`app.workers.process.Process`): on this machine or on a
cluster. Nothing here waits.
"""

from __future__ import annotations

from app.workers.process import Ended, Process
from app.workers.protocol import Job, Progress, Task
from app.workers.scheduler import Entry, Member

# How long a process that works may be without a sign of life, s: half a minute is common while it
# builds a solver, some minutes while it writes a long film.
SILENCE = 600.0


class PoolMember(Member):
    """One computing process and its job.

    Attributes:
        process: the process, wherever it runs.
        may_start: False once it could not, until the next request.
        was_ready: whether the process that is ending, or has ended, had started.
        wanted: whether a tab still waits for its job.
        todo: what to load when there is nothing else to do.
        stop_at, end_at: when to ask the running job to stop, and to end the process, s.
        start_by: when it has to be ready, s.
        silent_by: when it has to have given a sign of life, s.
        activity: the text of its job's last progress.
        progress: the job's last progress, as long as its tab has not got it.
        notify_at: when the tab may get the next, s.
    """

    def __init__(self, process: Process, *, reserved: bool, remote: bool = False) -> None:
        """Nothing runs before `start`.

        Args:
            process: none yet, but started when there is something to do.
            reserved: takes no job that lasts seconds.
            remote: on another machine.
        """
        super().__init__(reserved, remote)
        self.process = process
        self.may_start = True
        self.was_ready = False
        self.wanted = True
        self.todo: list[Task] = []
        self.stop_at: float | None = None
        self.end_at: float | None = None
        self.start_by = self.silent_by = 0.0
        self.activity = ""
        self.progress: Progress | None = None
        self.notify_at = 0.0

    # ---- the process

    @property
    def id(self) -> int | None:
        """Of the process, on its machine; None while there is none."""
        return self.process.id

    @property
    def exists(self) -> bool:
        """Whether there is a process, be it one that is ending."""
        return self.process.exists

    @property
    def starting(self) -> bool:
        """Whether there is a process that has not got ready yet."""
        return self.exists and not self.ready and not self.process.ending

    def start(self, now: float) -> None:
        """Start it; it sends `Ready` when it can take a job.

        Raises:
            OSError: the machine has no room for another process.
        """
        self.process.start()
        self.start_by = now + self.process.start_patience

    def send(self, job: Job) -> None:
        """Give it a job; returns at once.

        Raises:
            Exception: the job cannot be sent, whatever is wrong with it.
        """
        self.process.send(job)

    def ask_to_stop(self) -> None:
        """Have its job stop; from any thread."""
        if self.working_on is not None:
            self.stopping = True
            self.process.stop(self.working_on.job.number)

    def end(self, now: float, patience: float = 0.0, *, unexpected: bool = False) -> None:
        """Have it end; `poll` finds out when it has.

        Args:
            now: s.
            patience: s that it gets to exit by itself.
            unexpected: not on our order.
        """
        if self.exists and not self.process.ending:
            self.was_ready, self.ready = self.ready, False
            self.process.end(now, patience, unexpected=unexpected)

    def poll(self, now: float) -> Ended | None:
        """How it ended, if it was ending and has gone by now; then there is no process any more."""
        return self.process.poll(now)

    # ---- its job

    def begin(self, entry: Entry, now: float) -> None:
        """Have that job from now on."""
        self.working_on, self.wanted, self.stopping = entry, True, False
        self.activity, self.progress, self.notify_at = "", None, 0.0
        self.stop_at = self.end_at = None
        self.silent_by = now + SILENCE

    def finish(self) -> Entry | None:
        """Have no job any more; the one it had, if a tab waits for it."""
        entry, self.working_on = self.working_on, None
        self.stop_at = self.end_at = self.progress = None
        return entry if self.wanted else None

    def plan_to_restore(self, but: Task | None) -> None:
        """Have a new process in its place load the same again: all but what ended the old one."""
        tasks: list[Task] = [*self.loaded.values(), *self.todo]
        self.todo = [task for task in tasks if task != but]
        self.loaded.clear()
