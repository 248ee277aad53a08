"""The jobs of the pool, and its places: a process each, which may come and go, and its job."""

from collections import deque
from collections.abc import Hashable
from dataclasses import dataclass, field

from app.workers.process import Process
from app.workers.reports import Listener, Progress, Report
from app.workers.seeds import Seeds
from app.workers.tasks import Job, PlanJump, Task

# How long a process that works may be without a sign of life, s: half a minute is common while it
# builds a solver, some minutes while it writes a long film.
SILENCE = 600.0
LOADED_AGAIN = 3  # Solvers that a process in place of another one begins with: one of each model


@dataclass(eq=False)
class Entry:
    """A job in the queue or on processes, and the tab that it is for."""

    tab: Hashable  # any name of it that can be a key
    number: int  # of the job
    task: Task  # the work
    listener: Listener  # called with its reports
    notify_at: float = 0.0  # when its tab gets to know the reason for waiting, s (monotonic clock)
    over: bool = False  # nothing more is reported: it has its outcome, or nobody waits for it
    batch: Seeds | None = None  # makes one outcome of those of the parts
    begun_again: bool = False  # a process was killed that had it

    def __post_init__(self) -> None:
        self.parts = deque(self.task.parts)  # that no process has yet

    def deliver(self, report: Report) -> None:
        """Call the listener that it has now: a tab that goes meanwhile gets nothing any more."""
        self.listener(report)


@dataclass(eq=False)
class Member:
    """One computing process and its job; nothing here waits."""

    process: Process
    reserved: bool  # takes no job that lasts seconds
    spare: bool = False  # beside the places: takes no jobs of tabs
    heavy: bool = False  # it holds too much memory, and is to be replaced
    running: bool = False  # its thread has started it and not yet seen it end
    ready: bool = False  # it has started
    ending: bool = False  # it was killed on our order
    may_start: bool = True  # False once it could not, until the next request
    killed_starting: bool = False  # the last time; it starts once more by itself
    start_by: float = 0.0  # when it has to be ready, s
    # what is in its memory (`Task.needs`), each with a task that it has solved; the last one last
    loaded: dict[Hashable, PlanJump] = field(default_factory=dict)
    todo: list[Task] = field(default_factory=list)  # to load when there is nothing else to do
    working_on: Entry | None = None  # its job, if it has one
    task: Task | None = None  # the part of it
    stopping: bool = False  # that job was requested to stop; it may go on for a while
    stop_at: float | None = None  # when to have the job stop, s
    end_at: float | None = None  # when to kill the process, s
    silent_by: float = 0.0  # when it has to have given a sign of life, s
    activity: str = ""  # the text of its job's last progress
    progress: Progress | None = None  # the job's last one, as long as its tab has not got it
    notify_at: float = 0.0  # when the tab may get the next, s

    @property
    def idle(self) -> bool:
        """Whether it can take a job."""
        return self.ready and self.working_on is None

    @property
    def starting(self) -> bool:
        """Whether it runs and has still to get ready."""
        return self.running and not self.ready and not self.ending

    @property
    def deadlines(self) -> list[float]:
        """When something of it is due, s."""
        if self.working_on is None or self.ending:
            return [self.start_by] if self.starting else []
        notify_at = None if self.progress is None else self.notify_at
        times = self.stop_at, self.end_at, self.silent_by, notify_at
        return [at for at in times if at is not None]

    def suits(self, task: Task) -> bool:
        """Whether it may take a task at all, once it has time."""
        return not self.spare and not (self.reserved and task.kind.long)

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

    def note_loaded(self, task: PlanJump) -> None:
        """It has solved that, and can solve the like at once."""
        self.loaded.pop(task.needs, None)
        self.loaded[task.needs] = task

    @property
    def used_last(self) -> list[Task]:
        """Tasks by which another process gets as quick with what is likely to come next."""
        return [*[*self.loaded.values()][-LOADED_AGAIN:]]

    def plan_to_restore(self, but: Task | None) -> None:
        """Have a new process load the same again: what was used last, but not what ended it."""
        self.todo = [task for task in [*self.used_last, *self.todo] if task != but]
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
