"""One place of the pool: a computing process, which may come and go, and its job; nothing waits."""

from __future__ import annotations

from app.workers.process import Process
from app.workers.protocol import Job, PlanJump, Progress
from app.workers.task import Task
from app.workers.waiting import Entry, Member

# How long a process that works may be without a sign of life, s: half a minute is common while it
# builds a solver, some minutes while it writes a long film.
SILENCE = 600.0


class PoolMember(Member):
    """One computing process and its job.

    Attributes:
        running: whether its thread has started it and not yet seen it end.
        ending: it was killed on our order.
        start_by: when it has to be ready, s.
        silent_by: when it has to have given a sign of life, s.
    """

    def __init__(self, process: Process, *, reserved: bool, remote: bool = False) -> None:
        super().__init__(reserved, remote)
        self.process = process  # wherever it runs
        self.running = self.ending = False
        self.may_start = True  # False once it could not, until the next request
        self.todo: list[Task] = []  # tasks to load when there is nothing else to do
        # stop_at, end_at: when to have the running job stop, and to kill the process, s
        self.stop_at: float | None = None
        self.end_at: float | None = None
        self.start_by = self.silent_by = 0.0
        self.activity = ""  # the text of its job's last progress
        # the job's last progress, as long as its tab has not got it
        self.progress: Progress | None = None
        self.notify_at = 0.0  # when the tab may get the next, s

    @property
    def id(self) -> int | None:
        """Of the process, on its machine; None while there is none."""
        return self.process.id

    def start(self, now: float) -> None:
        """Its thread is about to run it."""
        self.running, self.ending, self.ready = True, False, False
        self.start_by = now + self.process.start_patience

    def begin(self, entry: Entry, task: Task, now: float) -> Job:
        """Have that job, or part of one, from now on."""
        self.working_on, self.task, self.stopping = entry, task, False
        self.activity, self.progress, self.notify_at = "", None, 0.0
        self.stop_at = None
        self.end_at = None if task.limit is None else now + task.limit
        self.silent_by = now + SILENCE
        return Job(entry.number, task)

    def finish(self) -> Entry | None:
        """Have no job any more; the one that it had, if a tab waits for it."""
        entry, self.working_on, self.task = self.working_on, None, None
        self.stop_at = self.end_at = self.progress = None
        return None if entry is None or entry.over else entry

    def request_stop(self) -> None:
        """Have its job stop."""
        if self.working_on is not None:
            self.stopping = True
            self.process.stop(self.working_on.number)

    def kill(self) -> None:
        """End the process; a new one in its place loads the same."""
        if self.running and not self.ending:
            self.ending, self.ready = True, False
            self.process.kill()

    def plan_to_restore(self, but: Task | None) -> None:
        """Have a new process load the same again: all but what ended the old one."""
        tasks: list[Task] = [*self.loaded.values(), *self.todo]
        self.todo = [task for task in tasks if task != but]
        self.loaded.clear()

    def supersede(self, newer: Task, now: float, grace: float) -> None:
        """Have the job stop in favour of its tab's newer one, a patient plan after `grace`, s."""
        if self.task is None or self.stop_at is not None or self.stopping:
            return
        patient = isinstance(self.task, PlanJump) and self.task.patient
        hurried = isinstance(newer, PlanJump) and not newer.patient
        if self.task.kind.gives_way or (patient and hurried):
            # The hand that rested has moved on, and the plan for its new place is not to wait.
            self.stop_at = now
        elif patient:
            self.stop_at = now + grace
