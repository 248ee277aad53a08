"""What runs inside a worker of the cluster: a computing process of its own, and its messages.

The worker itself computes nothing, so that it answers the scheduler whatever a solver does, and a
job that does not stop can be ended with its process, as on the server's machine.
"""

from __future__ import annotations

import asyncio
import contextlib
import multiprocessing
import pickle
import time

from app.workers.channel import Received
from app.workers.planner import PlannerFactory
from app.workers.process import EXIT_PATIENCE, Ended, LocalProcess
from app.workers.protocol import Job, Progress, Ready, Report, SimulatedSoFar

# An answer to the server comes after this time at the latest, s, be it an empty one: so it knows
# that the worker is there.
KEEP_ALIVE = 2.0
# A server that has not asked for so long has gone, s; the process ends.
LEASE = 30.0
# Least time between two pieces of progress, s: as much as a tab is shown.
PROGRESS_INTERVAL = 0.1
# Time between two looks at a process, and at one that is ending, s.
_LOOK_INTERVAL, _POLL_INTERVAL = 0.2, 0.01

Message = Ready | Report | Ended


class Host:
    """A dask actor: one computing process, from its start to its end.

    Its methods run on the worker's event loop and do not hold it up.
    """

    def __init__(self, factory: PlannerFactory, name: str) -> None:
        """Nothing runs before `start`.

        Args:
            factory: makes the planner inside the process.
            name: of the process.
        """
        self._factory = factory
        self._name = name

    async def start(self) -> int:
        """Start the process; its number.

        Raises:
            OSError: the machine has no room for another process.
        """
        # Dask's nanny starts workers as daemons, which may have no children. It ends its worker by
        # itself, and ours end when their connection to it does.
        multiprocessing.current_process().daemon = False
        self._messages: asyncio.Queue[Message] = asyncio.Queue()
        self._asked_at = self._answered_at = time.monotonic()
        self._process = LocalProcess(
            multiprocessing.get_context("spawn"),
            self._factory,
            _LoopSink(asyncio.get_running_loop(), self),
            self._name,
        )
        self._process.start()
        self._watching = asyncio.create_task(self._watch())
        assert self._process.id is not None
        return self._process.id

    async def send(self, content: bytes) -> None:
        """Give the process a job.

        Args:
            content: the pickled job.
        """
        job: Job = pickle.loads(content)  # noqa: S301  # of the server that started this
        self._process.send(job)

    async def stop(self, number: int) -> None:
        """Have the job with this number stop."""
        self._process.stop(number)

    async def end(self, patience: float) -> None:
        """Have the process end, after `patience` seconds; its last message is `Ended`."""
        self._process.end(time.monotonic(), patience)

    async def messages(self) -> bytes:
        """The next messages as a pickled list; after `KEEP_ALIVE` an empty one.

        Of progress only the newest is passed on, and not too often; all else goes at once.
        """
        self._asked_at = time.monotonic()
        taken: list[Message] = []
        until = self._asked_at + KEEP_ALIVE
        while not taken or _may_wait(taken[-1]):
            try:
                async with asyncio.timeout(until - time.monotonic()):
                    taken.append(await self._messages.get())
            except TimeoutError:
                break
            until = self._answered_at + PROGRESS_INTERVAL
        self._asked_at = self._answered_at = time.monotonic()
        return pickle.dumps(_newest(taken))

    def take(self, received: Received) -> None:
        """A message of the process; on the loop."""
        if received.message is not None:
            self._messages.put_nowait(received.message)
        elif received.channel is self._process.channel:
            self._process.end(time.monotonic(), EXIT_PATIENCE, unexpected=True)

    async def _watch(self) -> None:
        while True:
            now = time.monotonic()
            ended = self._process.poll(now)
            if ended is not None:
                self._messages.put_nowait(ended)
                return
            if now > self._asked_at + LEASE:
                self._process.end(now)
            await asyncio.sleep(_POLL_INTERVAL if self._process.ending else _LOOK_INTERVAL)


class _LoopSink:
    """Passes messages from the thread that reads them to the loop."""

    def __init__(self, loop: asyncio.AbstractEventLoop, host: Host) -> None:
        self._loop = loop
        self._host = host

    def put(self, received: Received, /) -> None:
        """See `app.workers.channel.Sink`."""
        with contextlib.suppress(RuntimeError):  # the worker has ended, and its loop with it
            self._loop.call_soon_threadsafe(self._host.take, received)


def _may_wait(message: Message) -> bool:
    """Whether a newer one of its kind takes its place."""
    return isinstance(message, Progress | SimulatedSoFar)


def _newest(messages: list[Message]) -> list[Message]:
    """Without progress that newer progress has overtaken."""
    last = {type(message): message for message in messages}
    return [m for m in messages if not _may_wait(m) or last[type(m)] is m]
