"""One computing process as the server knows it: started, given jobs, asked to stop, ended.

Nothing here waits: a process that ends is looked at again and again until it has gone.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any

from app.compute import worker
from app.compute.channel import Channel, Inbox
from app.compute.planner import PlannerFactory
from app.compute.protocol import Job, Progress, Task
from app.compute.scheduler import Entry, Member

# How long a process may take to be ready, s: it imports for 1 s, on a busy machine for some more.
START_PATIENCE = 60.0
# How long one whose connection has closed may take to exit by itself; and how long one that was
# told to end may take before it is killed, and before it is given up, s. The latter are never used
# up unless the machine is stuck.
EXIT_PATIENCE, END_PATIENCE, KILL_PATIENCE = 1.0, 1.0, 2.0
# How long a process that works may be without a sign of life, s: half a minute is common while it
# builds a solver, some minutes while it writes a long film.
SILENCE = 600.0


@dataclass
class _Ending:
    """When to do what to a process that shall end, s; and the reason."""

    terminate_at: float
    kill_at: float
    give_up_at: float
    unexpected: bool
    was_ready: bool


@dataclass(frozen=True)
class Ended:
    """How a process ended.

    Attributes:
        how: its exit status, or signal.
        unexpected: by itself, or because it never got ready; otherwise on our order.
        was_ready: whether it had started.
    """

    how: str
    unexpected: bool
    was_ready: bool


class WorkerProcess(Member):
    """One computing process, which may come and go, and its job.

    Attributes:
        id: of the process; None while there is none.
        channel: to it; None while there is none, or it is ending.
        may_start: False once it could not, until the next request.
        wanted: whether a tab still waits for its job.
        todo: what to load when there is nothing else to do.
        stop_at, end_at: when to ask the running job to stop, and to end the process, s.
        start_by: when it has to be ready, s.
        silent_by: when it has to have given a sign of life, s.
        activity: the text of its job's last progress.
        progress: the job's last progress, as long as its tab has not got it.
        notify_at: when the tab may get the next, s.
    """

    def __init__(
        self,
        context: SpawnContext,
        factory: PlannerFactory,
        inbox: Inbox,
        number: int,
        *,
        reserved: bool,
    ) -> None:
        """Nothing runs before `start`.

        Args:
            context: spawns; a forked child would inherit the server's sockets and threads' locks.
            factory: makes the planner inside the process.
            inbox: gets all that the process sends.
            number: for its name.
            reserved: takes no job that lasts seconds.
        """
        super().__init__(reserved)
        self._context = context
        self._factory = factory
        self._inbox = inbox
        self._name = f"llsrbm-computing-{number}"
        self._stop: Any = context.Value(ctypes.c_longlong, 0, lock=False)
        self._process: SpawnProcess | None = None
        self._ending: _Ending | None = None
        self.id: int | None = None
        self.channel: Channel | None = None
        self.may_start = True
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
    def exists(self) -> bool:
        """Whether there is a process, be it one that is ending."""
        return self._process is not None

    @property
    def ending(self) -> bool:
        """Whether the process is ending."""
        return self._ending is not None

    @property
    def starting(self) -> bool:
        """Whether there is a process that has not got ready yet."""
        return self.exists and not self.ready and not self.ending

    def start(self, now: float) -> None:
        """Start it; it sends `Ready` when it can take a job.

        Raises:
            OSError: the machine has no room for another process.
        """
        ours, theirs = self._context.Pipe()
        process = self._context.Process(
            target=worker.main,
            args=(theirs, self._stop, self._factory),
            name=self._name,
            daemon=True,
        )
        try:
            process.start()
        except BaseException:
            ours.close()
            raise
        finally:
            # Only the child may hold its end, or its death would go unnoticed.
            theirs.close()
        self._process = process
        self.id = process.pid
        self.start_by = now + START_PATIENCE
        self.channel = Channel(ours, self._inbox, self._name)

    def send(self, job: Job) -> None:
        """Give it a job; returns at once.

        Raises:
            Exception: the job cannot be sent, whatever is wrong with it.
        """
        if self.channel is not None:
            self.channel.send(job)

    def ask_to_stop(self) -> None:
        """Have its job stop; from any thread."""
        if self.working_on is not None:
            self.stopping = True
            self._stop.value = self.working_on.job.number

    def end(self, now: float, patience: float = 0.0, *, unexpected: bool = False) -> None:
        """Have it end; `poll` finds out when it has.

        Args:
            now: s.
            patience: s that it gets to exit by itself.
            unexpected: not on our order.
        """
        if self._process is None or self._ending is not None:
            return
        end_at = now + patience
        kill_at = end_at + END_PATIENCE
        self._ending = _Ending(end_at, kill_at, kill_at + KILL_PATIENCE, unexpected, self.ready)
        self.channel = None
        self.ready = False
        self.poll_signals(now)

    def poll_signals(self, now: float) -> None:
        """Send the signal that is due to a process that is ending."""
        ending, process = self._ending, self._process
        if ending is None or process is None or not process.is_alive():
            return
        if now >= ending.kill_at:
            process.kill()
        elif now >= ending.terminate_at:
            process.terminate()

    def poll(self, now: float) -> Ended | None:
        """How it ended, if it was ending and has gone by now; then there is no process any more."""
        ending, process = self._ending, self._process
        if ending is None or process is None:
            return None
        if process.is_alive():
            self.poll_signals(now)
            if now < ending.give_up_at:
                return None
            how = "it cannot even be killed"  # the kernel holds it; it is left to itself
        else:
            exit_code = process.exitcode or 0
            how = f"signal {-exit_code}" if exit_code < 0 else f"exit status {exit_code}"
            process.close()
        self._process = self._ending = self.id = None
        return Ended(how, ending.unexpected, ending.was_ready)

    def kill(self) -> None:
        """Kill it without looking at anything; from any thread, when the pool's has gone."""
        process = self._process
        if process is not None and process.is_alive():
            process.kill()

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
