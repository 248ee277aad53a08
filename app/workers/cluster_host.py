"""A computing process beside a worker of the cluster, and its messages: what runs there.

The worker itself computes nothing, so that it answers the scheduler whatever a solver does, and a
job that does not stop can be ended with its process, as on the server's machine.
"""

from __future__ import annotations

import asyncio
import contextlib
import multiprocessing
import pickle
import threading
import time

from app.workers.process import Ended, LocalProcess
from app.workers.reports import Progress, Ready, Report, SimulatedSoFar
from app.workers.tasks import Job, PlannerFactory

# An answer to the server comes after this time at the latest, s, be it an empty one: so it knows
# that the worker is there.
KEEP_ALIVE = 2.0
# A server that has sent no request for so long has gone, s; the process ends.
LEASE = 30.0
# Least time between two pieces of progress, s: as much as a tab is shown.
PROGRESS_INTERVAL = 0.1
_LOOK_INTERVAL = 1.0  # s between looks at the lease

Message = Ready | Report | Ended


class Host:
    """A dask actor: one computing process; its methods do not hold the worker's loop up."""

    def __init__(self, factory: PlannerFactory, name: str) -> None:
        self._factory, self._name = factory, name

    async def start(self) -> None:
        """Start the process; its last message is `Ended`."""
        # Dask's nanny starts workers as daemons, which may have no children. It ends its worker by
        # itself, and ours end when their connection to it does.
        multiprocessing.current_process().daemon = False
        self._messages: asyncio.Queue[Message] = asyncio.Queue()
        self._loop = asyncio.get_running_loop()
        self._requested_at = self._answered_at = time.monotonic()
        self._process = LocalProcess(self._factory, self._name)
        threading.Thread(target=self._read, name=f"{self._name}-reader", daemon=True).start()
        self._lease = asyncio.create_task(self._keep_lease())

    async def send(self, content: bytes) -> None:
        """Give the process a pickled job."""
        job: Job = pickle.loads(content)  # noqa: S301  # of the server that started this
        self._process.send(job, lambda _error: self._process.kill())

    async def stop(self, number: int) -> None:
        """Have the job with this number stop."""
        self._process.stop(number)

    async def kill(self) -> None:
        """End the process."""
        self._process.kill()

    async def messages(self) -> bytes:
        """The process' number and its next messages, pickled; after `KEEP_ALIVE` none.

        Of progress only the newest is passed on, and not too often; all else goes at once.
        """
        self._requested_at = time.monotonic()
        taken: list[Message] = []
        until = self._requested_at + KEEP_ALIVE
        while not taken or _may_wait(taken[-1]):
            try:
                async with asyncio.timeout(until - time.monotonic()):
                    taken.append(await self._messages.get())
            except TimeoutError:
                break
            until = self._answered_at + PROGRESS_INTERVAL
        self._requested_at = self._answered_at = time.monotonic()
        last = {type(message): message for message in taken}
        newest = [m for m in taken if not _may_wait(m) or last[type(m)] is m]
        return pickle.dumps((self._process.id, newest))

    def _read(self) -> None:
        try:
            for message in self._process.run():
                self._put(message)
        except Ended as ended:
            self._put(ended)

    def _put(self, message: Message) -> None:
        with contextlib.suppress(RuntimeError):  # the worker has ended, and its loop with it
            self._loop.call_soon_threadsafe(self._messages.put_nowait, message)

    async def _keep_lease(self) -> None:
        while time.monotonic() < self._requested_at + LEASE:
            await asyncio.sleep(_LOOK_INTERVAL)
        self._process.kill()


def _may_wait(message: Message) -> bool:
    return isinstance(message, Progress | SimulatedSoFar)
