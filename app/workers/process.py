"""A computing process as the server knows it: started, given jobs, asked to stop, ended.

Nothing here waits: a process that ends is looked at again and again until it has gone.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any, Protocol

from app.workers import worker
from app.workers.channel import Channel, Sink
from app.workers.planner import PlannerFactory
from app.workers.protocol import Job

# How long a process may take to be ready, s: it imports for 1 s, on a busy machine for some more.
START_PATIENCE = 60.0
# How long one whose connection has closed may take to exit by itself; and how long one that was
# told to end may take before it is killed, and before it is given up, s. The latter are never used
# up unless the machine is stuck.
EXIT_PATIENCE, END_PATIENCE, KILL_PATIENCE = 1.0, 1.0, 2.0


@dataclass(frozen=True)
class Ended:
    """How a process ended.

    Attributes:
        how: its exit status, or signal.
        unexpected: by itself, or because it never got ready; otherwise on our order.
        logged: whether the terminal has been told the reason already.
    """

    how: str
    unexpected: bool
    logged: bool = False


class Process(Protocol):
    """A process that computes, on this machine or another; it may come and go.

    All but `stop` and `kill` are called by the pool's own thread, and none waits.
    """

    @property
    def id(self) -> int | None:
        """Of the process, on its machine; None while there is none."""
        ...

    @property
    def channel(self) -> object | None:
        """Where its messages come from (`Received.channel`); None: it has gone, or is ending."""
        ...

    @property
    def exists(self) -> bool:
        """Whether there is a process, be it one that is ending."""
        ...

    @property
    def ending(self) -> bool:
        """Whether the process is ending."""
        ...

    @property
    def startable(self) -> bool:
        """Whether there is a machine that it could be started on."""
        ...

    @property
    def start_patience(self) -> float:
        """How long it may take to be ready, s."""
        ...

    def start(self) -> None:
        """Start it; it sends `Ready` when it can take a job.

        Raises:
            OSError: the machine has no room for another process.
        """
        ...

    def send(self, job: Job) -> None:
        """Give it a job; returns at once.

        Raises:
            Exception: the job cannot be sent, whatever is wrong with it.
        """
        ...

    def stop(self, number: int) -> None:
        """Have the job with this number stop; from any thread."""
        ...

    def end(self, now: float, patience: float = 0.0, *, unexpected: bool = False) -> None:
        """Have it end; `poll` finds out when it has.

        Args:
            now: s.
            patience: s that it gets to exit by itself.
            unexpected: not on our order.
        """
        ...

    def poll(self, now: float) -> Ended | None:
        """How it ended, if it was ending and has gone by now; then there is no process any more."""
        ...

    def kill(self) -> None:
        """Kill it without looking at anything; from any thread, when the pool's has gone."""
        ...


@dataclass
class _Ending:
    """When to do what to a process that shall end, s."""

    terminate_at: float
    kill_at: float
    give_up_at: float
    unexpected: bool


class LocalProcess:
    """A process of this machine; see `Process`.

    Attributes:
        id: of the process; None while there is none.
        channel: to it; None while there is none, or it is ending.
        startable: always.
    """

    startable = True

    def __init__(
        self, context: SpawnContext, factory: PlannerFactory, inbox: Sink, name: str
    ) -> None:
        """Nothing runs before `start`.

        Args:
            context: spawns; a forked child would inherit the server's sockets and threads' locks.
            factory: makes the planner inside the process.
            inbox: gets all that the process sends.
            name: of the process.
        """
        self._context = context
        self._factory = factory
        self._inbox = inbox
        self._name = name
        self._stop: Any = context.Value(ctypes.c_longlong, 0, lock=False)
        self._process: SpawnProcess | None = None
        self._ending: _Ending | None = None
        self.id: int | None = None
        self.channel: Channel | None = None

    @property
    def exists(self) -> bool:
        """See `Process.exists`."""
        return self._process is not None

    @property
    def ending(self) -> bool:
        """See `Process.ending`."""
        return self._ending is not None

    @property
    def start_patience(self) -> float:
        """See `Process.start_patience`."""
        return START_PATIENCE

    def start(self) -> None:
        """See `Process.start`."""
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
        self.channel = Channel(ours, self._inbox, self._name)

    def send(self, job: Job) -> None:
        """See `Process.send`."""
        if self.channel is not None:
            self.channel.send(job)

    def stop(self, number: int) -> None:
        """See `Process.stop`."""
        self._stop.value = number

    def end(self, now: float, patience: float = 0.0, *, unexpected: bool = False) -> None:
        """See `Process.end`."""
        if self._process is None or self._ending is not None:
            return
        end_at = now + patience
        kill_at = end_at + END_PATIENCE
        self._ending = _Ending(end_at, kill_at, kill_at + KILL_PATIENCE, unexpected)
        self.channel = None
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
        """See `Process.poll`."""
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
        return Ended(how, ending.unexpected)

    def kill(self) -> None:
        """See `Process.kill`."""
        process = self._process
        if process is not None and process.is_alive():
            process.kill()
