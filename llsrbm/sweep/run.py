"""Hands the jumps of a sweep out to Dask workers, a task each, and keeps their rows in order.

A few tasks a worker are under way at a time, so that neither the scheduler nor this process holds
more than those.
"""

import asyncio
import logging
import math
import queue
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from itertools import takewhile
from typing import Any

import dask
import distributed
from distributed.client import FutureCancelledError
from distributed.comm import CommClosedError, get_address_host
from distributed.scheduler import KilledWorker

from llsrbm.errors import Error, InputError
from llsrbm.number_text import duration
from llsrbm.sweep import interrupts
from llsrbm.sweep.folder import Folder, difference
from llsrbm.sweep.jump import failed_rows, run_jump, run_prepare
from llsrbm.sweep.points import Points
from llsrbm.sweep.rows import FAILED, TableRow
from llsrbm.sweep.spec import Spec

GO_ON = "what is done is kept: run the same command again to go on"

LARGE = 10**6
"""Rows from which on a sweep is to be confirmed: more than two days on two workers."""

# s a jump on one core, mean of the three robots, failures included; diagnoses spread over all.
_PLAN_TIME, _SIMULATION_TIME, _DIAGNOSIS_TIME = 0.5, 1.1, 3.0
_WHOLE_BODY_TIME = 2.3  # s likewise, with the certificate: Go2 and ANYmal, interpreted
# bytes; Parquet packs rows of planned jumps to this, and motions hardly at all.
_BYTES_A_ROW, _BYTES_A_MOTION = 500, 50_000

_UNDER_WAY = 2  # tasks a worker, so that it need not wait for its next one
_MOST_HELD = 20_000  # jumps that wait for one before them to be written
_ANSWER_TIME = 10.0  # s in which a scheduler has to answer
_LOOK_TIME = 1.0  # s between looks at the clock while jumps are computed
_COUNT_WORKERS = 5.0  # s between looks at how many workers there are
_DEATHS = 3  # workers that may die of a jump before it is given up
_LIMIT, _LIMIT_A_ROW = 300.0, 30.0  # s that a jump may take, and its rows beyond that


@dataclass(frozen=True)
class Estimate:
    """Jumps and rows of a sweep, and roughly its time (s) on one worker and its size (bytes)."""

    jumps: int
    rows: int
    seconds: float
    size: float

    def line(self, workers: int | None) -> str:
        """One line; `workers`: their number, None: not known."""
        many = f" on {workers} worker{'s' if (workers or 0) > 1 else ''}"
        long = duration(self.seconds / (workers or 1))
        long += many if workers else " of work for the cluster"
        power = min(max(int(math.log10(self.size) // 3), 1), 4)
        size = f"about {self.size / 1e3**power:.1f} {' kMGT'[power]}B"
        return f"{self.jumps} jumps, {self.rows} rows; expected {long}, {size}"


def estimate(points: Points) -> Estimate:
    """Time and disk of a whole sweep."""
    spec = points.spec
    a_jump = _PLAN_TIME + spec.diagnose * _DIAGNOSIS_TIME
    seconds = points.count * (a_jump + (not spec.draft) * _WHOLE_BODY_TIME)
    seconds += points.rows * spec.simulated * _SIMULATION_TIME
    size = points.rows * _BYTES_A_ROW + points.count * spec.trajectories * _BYTES_A_MOTION
    return Estimate(points.count, points.rows, seconds, size)


def default_limit(spec: Spec) -> float:
    """Time (s) that a jump may take with all its simulations; most take a second or two."""
    return _LIMIT + _LIMIT_A_ROW * spec.rows_a_jump()


@dataclass
class Progress:
    """Progress of a sweep."""

    jumps: int  # of the sweep
    done: int  # of them, also earlier
    begun_at: int  # `done` when this run began
    workers: int = 0  # at the moment
    seconds: float = 0.0  # of this run
    planning: float = 0.0  # of its workers, summed
    simulating: float = 0.0  # of its workers, summed

    @property
    def rate(self) -> float:
        """Jumps a second of this run."""
        return (self.done - self.begun_at) / self.seconds if self.seconds else 0.0

    @property
    def busy(self) -> float:
        """Share of the workers' time, from start to end, inside planning and simulation."""
        whole = self.workers * self.seconds
        return (self.planning + self.simulating) / whole if whole else 0.0


@contextmanager
def connected(workers: int, scheduler: str | None) -> Iterator[distributed.Client]:
    """A client of the scheduler at that address, "tcp://host:8786"; None: of a new local one.

    `workers`: processes of a local one, a thread each. Raises `InputError`: no scheduler answers.
    """
    settings: dict[str, Any] = {
        "distributed.scheduler.allowed-failures": _DEATHS,
        "distributed.comm.timeouts.connect": f"{_ANSWER_TIME}s",
        # One task less on its way to a worker is one less that its death delays.
        "distributed.admin.low-level-log-length": 0,
    }
    # Its loggers, some of which have levels of their own, use many lines where we print one.
    names = {"distributed", "distributed.client", *dask.config.get("logging", {})}
    levels = {logger: logger.level for logger in map(logging.getLogger, sorted(names))}
    for logger in levels:
        logger.setLevel(logging.CRITICAL)
    try:
        with dask.config.set(settings):
            cluster: Any = nullcontext()
            if scheduler is None:
                cluster = distributed.LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    preload=[interrupts.__name__],
                    dashboard_address="127.0.0.1:0",
                    silence_logs=logging.CRITICAL,
                )
            with (
                cluster,
                _existing(scheduler) if scheduler else distributed.Client(cluster) as client,
            ):
                yield client
    finally:
        for logger, level in levels.items():
            logger.setLevel(level)


def _existing(scheduler: str) -> distributed.Client:
    try:
        # A client waits for ever for something that takes the connection and sends nothing.
        # In a thread of its own: this one may have an event loop already, as in a notebook.
        with ThreadPoolExecutor(1) as thread:
            answer = asyncio.wait_for(_identity(scheduler), _ANSWER_TIME)
            thread.submit(asyncio.run, answer).result()
        return distributed.Client(scheduler, timeout=f"{_ANSWER_TIME}s")
    except Exception as error:  # whatever another service's answer makes of Dask's reader
        raise InputError(
            f"--scheduler {scheduler}: no Dask scheduler answers there within {_ANSWER_TIME:.0f} "
            "s; expected the address of one that runs, such as tcp://127.0.0.1:8786"
        ) from error


async def _identity(scheduler: str) -> Any:
    async with distributed.rpc(scheduler) as remote:
        return await remote.identity()


def run(
    folder: Folder,
    client: distributed.Client,
    origin: Mapping[str, str],
    *,
    limit: float,
    progress: Callable[[Progress], None],
    note: Callable[[str], None],
) -> Progress:
    """Compute all jumps of a folder that are missing.

    Args:
        client: of a scheduler with workers, or soon with some.
        origin: versions that workers must have; limit: time (s) that a jump may take.
        progress: called about every second; note: with a line of anything else to report.

    Raises:
        Error: the scheduler is lost, a worker cannot run the sweep, or the disk is full; what is
            done is kept.
    """
    work = _Work(folder, client, dict(origin), limit, progress, note)
    try:
        work.prepare()
        work.run()
    except (FutureCancelledError, CancelledError, CommClosedError, OSError) as error:
        raise Error(f"the scheduler is lost ({type(error).__name__}); {GO_ON}") from error
    return work.so_far


@dataclass
class _Work:
    """The tasks under way, and the rows that wait for those of earlier jumps."""

    folder: Folder
    client: distributed.Client
    origin: dict[str, str]
    limit: float
    progress: Callable[[Progress], None]
    note: Callable[[str], None]

    def __post_init__(self) -> None:
        self._missing = self.folder.missing()
        self._flight: dict[distributed.Future, int] = {}
        self._ended: queue.SimpleQueue[distributed.Future] = queue.SimpleQueue()
        # Jumps that were handed out and are not written, in order; None: under way.
        self._held: dict[int, list[TableRow] | None] = {}
        self._counted = -math.inf
        done = int(self.folder.done.sum())
        self.so_far = Progress(self.folder.points.count, done, done)
        self._start = time.perf_counter()

    def prepare(self) -> None:
        """Have one worker of each machine fill its cache, before all of them do the same."""
        self._count_workers()
        if self.so_far.workers == 0:
            self.note("waiting for workers")
        while self.so_far.workers == 0:
            time.sleep(_LOOK_TIME)
            self._count_workers()
        spec, kinds = self.folder.points.spec, [*self.folder.points.kinds()]
        hosts = {get_address_host(address): address for address in self.client.nthreads()}
        futures = [
            # A worker that dies comes back with another address.
            self.client.submit(
                run_prepare, spec, kinds, workers=[address], allow_other_workers=True, pure=False
            )
            for address in hosts.values()
        ]
        self.note("loading the solvers; those that are built for the first time take a minute")
        for future in futures:
            if isinstance(future.exception(), KilledWorker):
                raise Error(
                    f"{_DEATHS + 1} workers died while they loaded the solvers; expected about a "
                    f"gigabyte of memory for each; {GO_ON}"
                )
            self._check(future)
        self._start = time.perf_counter()

    def run(self) -> None:
        """Until no jump is missing."""
        self._hand_out()
        while self._flight:
            self._take(self._next_ended())
            for jump, rows in [*takewhile(lambda held: held[1] is not None, self._held.items())]:
                self.folder.append(jump, rows or [])
                del self._held[jump]
            self._hand_out()
            self.so_far.seconds = time.perf_counter() - self._start
            self.progress(self.so_far)
        self.folder.flush()

    def _hand_out(self) -> None:
        self._count_workers()
        most = _UNDER_WAY * max(self.so_far.workers, 1)
        while len(self._flight) < most and len(self._held) < _MOST_HELD:
            jump = next(self._missing, None)
            if jump is None:
                return
            point = self.folder.points[jump]
            future = self.client.submit(
                run_jump, self.folder.points.spec, point, self.limit, pure=False
            )
            self._flight[future] = jump
            self._held[jump] = None
            future.add_done_callback(self._ended.put)

    def _next_ended(self) -> list[distributed.Future]:
        """Tasks that have ended, after a second an empty list."""
        try:
            ended = {self._ended.get(timeout=_LOOK_TIME)}
            while not self._ended.empty():
                ended.add(self._ended.get())
        except queue.Empty:  # Dask calls nothing where the scheduler is lost
            ended = {future for future in self._flight if future.done()}
        return [future for future in ended if future in self._flight]

    def _take(self, ended: list[distributed.Future]) -> None:
        whole = [future for future in ended if future.status == "finished"]
        results = dict(zip(whole, self.client.gather(whole), strict=True))
        for future in ended:
            jump = self._flight.pop(future)
            if future in results:
                future.release()
                found = results[future]
            elif isinstance(future.exception(), KilledWorker):
                self.note(f"jump {jump} kills workers; its rows say so")
                message = f"{_DEATHS + 1} workers died while they computed it"
                found = failed_rows(self.folder.points[jump], FAILED, message)
            else:
                self._check(future)
            for row in found:
                versions = {"llsrbm": row["version"], row["robot"]: row["robot_hash"]}
                here = {name: self.origin.get(name, "") for name in versions}
                if other := difference(versions, here):
                    raise Error(f"a worker has {other}; expected the same everywhere; {GO_ON}")
            self._held[jump] = found
            self.so_far.done += 1
            self.so_far.planning += found[0].get("plan_time_s") or 0.0
            self.so_far.simulating += sum(row.get("simulation_time_s") or 0.0 for row in found)

    def _check(self, future: distributed.Future) -> None:
        """Raise `Error` if a task failed before it could compute anything."""
        try:
            future.result()
        except Exception as error:
            if future.status != "error":  # not the worker's, but the connection's
                raise
            raise Error(
                f"a worker cannot run the sweep ({type(error).__name__}: {error}); expected "
                f"llsrbm {self.origin['llsrbm']} and the robots' files on every worker; {GO_ON}"
            ) from error
        finally:
            future.release()

    def _count_workers(self) -> None:
        now = time.perf_counter()
        if now - self._counted > _COUNT_WORKERS or self.so_far.workers == 0:
            self._counted = now
            self.so_far.workers = sum(self.client.nthreads().values())
