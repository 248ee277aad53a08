"""Hands shards of a sweep out to Dask workers and keeps what comes back.

Few shards are under way at a time, so that neither the scheduler nor this process holds more than
those. How many jumps a shard has follows from the rate measured so far, and changes no row.
"""

from __future__ import annotations

import asyncio
import logging
import math
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from typing import Any

import dask
import distributed
from distributed.client import FutureCancelledError
from distributed.comm import CommClosedError, get_address_host
from distributed.scheduler import KilledWorker

from llsrbm.errors import Error, InputError
from llsrbm.sweep.shard import Shard, lost_shard, prepare, run_shard
from llsrbm.sweep.table import Folder

GO_ON = "what is done is kept: run the same command again to go on"

_SHARD_TIME = (
    10.0  # s that a shard takes: long beside Dask's overhead of milliseconds, short to lose
)
_MOST_JUMPS = 500  # of a shard, so that its rows stay below a megabyte
_UNDER_WAY = 2  # shards a worker, so that it need not wait for its next one
_ANSWER_TIME = 10.0  # s in which a scheduler has to answer
_LOOK_TIME = 1.0  # s between looks at the clock while shards are computed
_COUNT_WORKERS = 5.0  # s between looks at how many workers there are
_DEATHS = 3  # workers that a shard may lose before it is suspected of killing them
_MEMORY = 0.2  # how much the newest shard counts in the rate


@dataclass
class Progress:
    """How far a sweep is.

    Attributes:
        jumps: of the sweep; done: of them, also earlier; begun_at: `done` when this run began.
        workers: at the moment.
        seconds: of this run; planning, simulating: of its workers, summed.
    """

    jumps: int
    done: int
    begun_at: int
    workers: int = 0
    seconds: float = 0.0
    planning: float = 0.0
    simulating: float = 0.0

    @property
    def rate(self) -> float:
        """Jumps a second of this run."""
        return (self.done - self.begun_at) / self.seconds if self.seconds else 0.0

    @property
    def left(self) -> float:
        """s; infinite before the first jump."""
        return (self.jumps - self.done) / self.rate if self.rate else math.inf

    @property
    def busy(self) -> float:
        """Share of the workers' time, from start to end, inside planning and simulation."""
        whole = self.workers * self.seconds
        return (self.planning + self.simulating) / whole if whole else 0.0

    def add(self, shard: Shard) -> None:
        """Count a shard."""
        self.done += len(shard.jumps)
        self.planning += shard.planning
        self.simulating += shard.simulating


@contextmanager
def connected(workers: int, scheduler: str | None) -> Iterator[distributed.Client]:
    """A client of a scheduler: a local one with its workers, or one that runs already.

    Args:
        workers: processes of a local cluster, a thread each.
        scheduler: address of one that runs, "tcp://host:8786"; None: a local one is started.

    Raises:
        InputError: the scheduler does not answer.
    """
    settings: dict[str, Any] = {
        "distributed.scheduler.allowed-failures": _DEATHS,
        "distributed.comm.timeouts.connect": f"{_ANSWER_TIME}s",
        # One task less on its way to a worker is one less that its death delays.
        "distributed.admin.low-level-log-length": 0,
    }
    # Its loggers, some of which have levels of their own, say in many lines what is said in one.
    names = {"distributed", "distributed.client", *dask.config.get("logging", {})}
    levels = {logger: logger.level for logger in map(logging.getLogger, sorted(names))}
    for logger in levels:
        logger.setLevel(logging.CRITICAL)
    try:
        with dask.config.set(settings):
            if scheduler is None:
                with (
                    distributed.LocalCluster(
                        n_workers=workers,
                        threads_per_worker=1,
                        processes=True,
                        dashboard_address="127.0.0.1:0",
                        silence_logs=logging.CRITICAL,
                    ) as cluster,
                    distributed.Client(cluster) as client,
                ):
                    yield client
                return
            with _existing(scheduler) as client:
                yield client
    finally:
        for logger, level in levels.items():
            logger.setLevel(level)


def _existing(scheduler: str) -> distributed.Client:
    try:
        # A client waits for ever for something that takes the connection and says nothing.
        # In a thread of its own: this one may have an event loop already, as in a notebook.
        with ThreadPoolExecutor(1) as thread:
            asked = asyncio.wait_for(_identity(scheduler), _ANSWER_TIME)
            thread.submit(asyncio.run, asked).result()
        return distributed.Client(scheduler, timeout=f"{_ANSWER_TIME}s")
    except Exception as error:  # whatever another service's answer makes of Dask's reader
        raise InputError(
            f"--scheduler {scheduler}: no Dask scheduler answers there within {_ANSWER_TIME:.0f} "
            "s; expected the address of one that runs, such as tcp://127.0.0.1:8786"
        ) from error


async def _identity(scheduler: str) -> Any:
    """What a scheduler says of itself."""
    async with distributed.rpc(scheduler) as remote:
        return await remote.identity()


def run(
    folder: Folder,
    client: distributed.Client,
    origin: Mapping[str, str],
    *,
    progress: Callable[[Progress], None],
    told: Callable[[str], None],
) -> Progress:
    """Compute all jumps that are missing.

    Args:
        folder: keeps them.
        client: of a scheduler with workers, or soon with some.
        origin: what workers' robots and version have to be, see `llsrbm.sweep.shard.origin`.
        progress: called about every second.
        told: called with a line when there is something else to say.

    Raises:
        Error: the scheduler is lost, a worker cannot run the sweep, or the disk is full; what is
            done is kept.
    """
    work = _Work(folder, client, origin, progress, told)
    with _lost():
        work.prepare()
        work.run()
    return work.so_far


@contextmanager
def _lost() -> Iterator[None]:
    try:
        yield
    except (FutureCancelledError, CancelledError, CommClosedError, OSError) as error:
        raise Error(f"the scheduler is lost ({type(error).__name__}); {GO_ON}") from error


class _Work:
    """What is under way."""

    def __init__(
        self,
        folder: Folder,
        client: distributed.Client,
        origin: Mapping[str, str],
        progress: Callable[[Progress], None],
        told: Callable[[str], None],
    ) -> None:
        self._folder, self._client, self._origin = folder, client, dict(origin)
        self._progress, self._told = progress, told
        self._spec = folder.points.spec.as_json()
        self._missing = folder.missing()
        self._suspects: deque[list[int]] = deque()
        self._flight: dict[distributed.Future, list[int]] = {}
        self._seconds_a_jump = 0.0
        self._counted = -math.inf
        done = int(folder.done.sum())
        self.so_far = Progress(folder.points.count, done, done)
        self._start = time.perf_counter()

    def prepare(self) -> None:
        """Have one worker of each machine fill its cache, before all of them do the same."""
        self._wait_for_workers()
        hosts = {get_address_host(address): address for address in self._client.nthreads()}
        futures = [
            self._client.submit(
                prepare,
                self._spec,
                workers=[address],
                allow_other_workers=True,  # a worker that dies comes back with another address
                pure=False,
            )
            for address in hosts.values()
        ]
        self._told("loading the solvers; those that are built for the first time take a minute")
        for future in futures:
            try:
                self._check(self._result(future))
            except KilledWorker as error:
                raise Error(
                    f"{_DEATHS + 1} workers died while they loaded the solvers; expected about a "
                    f"gigabyte of memory for each; {GO_ON}"
                ) from error
        self._start = time.perf_counter()

    def run(self) -> None:
        """Until nothing is missing."""
        self._fill()
        while self._flight:
            with suppress(TimeoutError):
                distributed.wait([*self._flight], timeout=_LOOK_TIME, return_when="FIRST_COMPLETED")
            for future in [future for future in self._flight if future.done()]:
                self._take(future, self._flight.pop(future))
            self._fill()
            self.so_far.seconds = time.perf_counter() - self._start
            self._progress(self.so_far)
        while self._suspects:
            self._alone(self._suspects.popleft())

    def _fill(self) -> None:
        """Send out as many shards as the workers can do with."""
        self._count_workers()
        while len(self._flight) < _UNDER_WAY * max(self.so_far.workers, 1):
            jumps = [*islice(self._missing, self._size())]
            if not jumps:
                return
            self._flight[self._submit(jumps)] = jumps

    def _size(self) -> int:
        """Jumps of the next shard: few before there is a rate, and so that all end together."""
        if not self._seconds_a_jump:
            return 1
        under_way = sum(map(len, self._flight.values()))
        left = self.so_far.jumps - self.so_far.done - under_way
        share = math.ceil(left / (_UNDER_WAY * max(self.so_far.workers, 1)))
        return max(1, min(int(_SHARD_TIME / self._seconds_a_jump), share, _MOST_JUMPS))

    def _submit(self, jumps: list[int]) -> distributed.Future:
        return self._client.submit(run_shard, self._spec, jumps, pure=False)

    def _take(self, future: distributed.Future, jumps: list[int]) -> None:
        """Keep what came back; a shard that did not is tried again, alone, at the end."""
        try:
            shard = self._result(future)
        except KilledWorker:
            self._suspects.append(jumps)
            return
        self._keep(shard)

    def _alone(self, jumps: list[int]) -> None:
        """Find out which jump it is that kills workers, with nothing else under way."""
        try:
            shard = self._result(self._submit(jumps))
        except KilledWorker as error:
            if len(jumps) > 1:
                middle = len(jumps) // 2
                self._suspects.extendleft([jumps[middle:], jumps[:middle]])
                return
            self._told(f"jump {jumps[0]} kills workers; its rows say so")
            points = self._folder.points
            message = f"{error.allowed_failures + 1} workers died while they computed it"
            shard = lost_shard(points.spec, points[jumps[0]], message)
        self._keep(shard)

    def _keep(self, shard: Shard) -> None:
        self._check(shard.origin)
        self._folder.write(shard)
        a_jump = shard.seconds / len(shard.jumps)
        before = self._seconds_a_jump or a_jump
        self._seconds_a_jump = max(before + _MEMORY * (a_jump - before), 1e-6)
        self.so_far.add(shard)
        self.so_far.seconds = time.perf_counter() - self._start
        self._progress(self.so_far)

    def _result(self, future: distributed.Future) -> Any:
        """What a worker hands back.

        Raises:
            KilledWorker: workers died of it, or by chance.
            Error: it could not begin.
        """
        try:
            return future.result()
        except KilledWorker:
            raise
        except Exception as error:
            if future.status != "error":  # not the worker's, but the connection's
                raise
            raise Error(
                f"a worker cannot run the sweep ({type(error).__name__}: {error}); expected "
                f"llsrbm {self._origin['llsrbm']} and the robots' files on every worker; {GO_ON}"
            ) from error
        finally:
            future.release()

    def _check(self, origin: Mapping[str, str]) -> None:
        for name, value in self._origin.items():
            if origin.get(name) != value:
                what = "llsrbm" if name == "llsrbm" else f"the robot {name}"
                raise Error(
                    f"a worker has {what} {origin.get(name)}, this machine {value}; expected the "
                    f"same everywhere; {GO_ON}"
                )

    def _wait_for_workers(self) -> None:
        self._count_workers()
        if self.so_far.workers == 0:
            self._told("waiting for workers")
        while self.so_far.workers == 0:
            time.sleep(_LOOK_TIME)
            self._count_workers()

    def _count_workers(self) -> None:
        now = time.perf_counter()
        if now - self._counted > _COUNT_WORKERS or self.so_far.workers == 0:
            self._counted = now
            self.so_far.workers = sum(self._client.nthreads().values())
