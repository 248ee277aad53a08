"""The workers of a dask cluster as places for computing processes; they come and go.

Only the scheduler has to be reachable: whatever is exchanged with a worker goes by way of it. One
thread has an event loop for all of that. Each thread of a worker is a place for one process; before
it counts, its worker has to prove that it has the same code (`code_identity`).
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import pickle
import sys
import threading
import time
import uuid
from collections import Counter
from collections.abc import Callable, Coroutine, Mapping
from concurrent.futures import Future
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import dask
from distributed import Client

import app
import llsrbm
from app.workers.cluster_process import ClusterProcess
from app.workers.tasks import PlannerFactory
from llsrbm.cache import content_key
from llsrbm.errors import InputError
from llsrbm.installed import assets_directory, package_version

# How long a scheduler may take to let us in, and its workers to say what code they have, s.
CONNECT_PATIENCE, IDENTITY_PATIENCE = 5.0, 3.0
# Time between two looks at who is there, s: a worker that joins or leaves is noticed after it.
LOOK_INTERVAL = 1.0
# How long a scheduler may take to answer a look, s: one that is busy with a sweep takes its time.
LOOK_PATIENCE = 10.0
# Time between two attempts to get back to a lost scheduler, s.
RETRY_INTERVAL = 5.0
# How long a worker where a process could not be started gets no other, s: a lasting defect there
# shall not keep the terminal busy.
BARRED = 30.0
# How long a process whose connection failed waits for the reason, s.
_REASON_PATIENCE = 1.0
_CLOSE_PATIENCE = 2.0  # s
# Before the pieces of a sweep: a page's process only has to be started, somebody waits for it.
_PRIORITY = 100

_log = logging.getLogger(__name__)


_DATA = ("robots", "jump_types")  # folders of what jumps depend on besides the sources
_SHOWN = 8  # hexadecimal digits of the key, in messages

AnyResult = TypeVar("AnyResult")


@dataclass(frozen=True)
class CodeIdentity:
    """The code of an installation: two machines with the same one compute the same.

    A cluster's workers are asked for theirs before they get a job; messages are pickled, so that
    another version would misread them, or answer with another planner's jumps.
    """

    version: str  # of the package
    key: str  # hash of the sources of library and page, and of what robots and jump types are
    python: str  # its version, as 3.11

    def __str__(self) -> str:
        return f"llsrbm {self.version} ({self.key[:_SHOWN]}) on Python {self.python}"


def code_identity() -> CodeIdentity:
    """Of the code that runs here, as its files are now."""
    folders = [Path(str(package.__file__)).parent for package in (app, llsrbm)]
    sources = [path for folder in folders for path in sorted(folder.rglob("*.py"))]
    # Names of the files do not count: sources and wheel have them in other places.
    data = [path for kind in _DATA for path in sorted((assets_directory() / kind).glob("*.toml"))]
    key = content_key(*sources, *data).hex()
    return CodeIdentity(package_version(), key, "{}.{}".format(*sys.version_info))


@dataclass(eq=False)
class Place:
    """A worker that has the same code."""

    address: str  # of the worker
    threads: int  # so many processes have room there
    gone: asyncio.Event = field(default_factory=asyncio.Event)  # set when it is not there any more
    barred_until: float = 0.0  # nothing is started there before, s (monotonic clock)


class Cluster:
    """A connection to a scheduler, renewed when it is lost."""

    def __init__(self, address: str) -> None:
        """Connect, and see who is there; raises `InputError` where nothing answers."""
        self.address = address  # of the scheduler, as it was given
        self._identity = code_identity()
        self._lock = threading.Lock()  # for the two below
        self._places: dict[str, Place] = {}
        self._taken: Counter[Place] = Counter()
        self._unfit: dict[str, str] = {}  # address of a worker -> why it gets nothing
        self._client: Any = None  # dask's Client, as long as it is connected
        self._changed: Callable[[], object] = _ignore
        self._remark: Callable[[str], object] = _log.warning
        self._looked: asyncio.Event = asyncio.Event()
        self._look_now: asyncio.Event = asyncio.Event()
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="cluster", daemon=True)
        self._thread.start()
        _quieten()
        try:
            self.run(self._connect()).result()
        except Exception as error:
            self._stop()
            late = f"no answer within {CONNECT_PATIENCE:g} s"
            why = late if isinstance(error, TimeoutError) else _reason(error)
            raise InputError(
                f"--scheduler: {address!r:.80}: {why}; expected the address of a "
                "running dask scheduler, for example tcp://127.0.0.1:8786"
            ) from error
        self._keeping = self.run(self._keep())

    # ---- from any thread

    def processes(self, factory: PlannerFactory, most: int) -> tuple[ClusterProcess, ...]:
        """At most so many processes, which may be started here as far as there are places."""
        return tuple(ClusterProcess(self, factory, f"llsrbm-cluster-{i + 1}") for i in range(most))

    def watch(self, changed: Callable[[], object], remark: Callable[[str], object]) -> None:
        """Call `changed` when a place may be free, `remark` with lines; by the cluster's thread."""
        self._changed, self._remark = changed, remark
        changed()

    @property
    def room(self) -> int:
        """Number of processes that have room, those that run among them."""
        with self._lock:
            return sum(place.threads for place in self._places.values())

    @property
    def has_room(self) -> bool:
        """Whether a place is free."""
        with self._lock:
            return self._freest() is not None

    def take(self) -> Place | None:
        """A place, where fewest are taken; None if there is none."""
        with self._lock:
            place = self._freest()
            if place is not None:
                self._taken[place] += 1
            return place

    def give_back(self, place: Place) -> None:
        """A place is not needed any more."""
        with self._lock:
            self._taken[place] -= 1
            if not self._taken[place]:
                del self._taken[place]

    def bar(self, place: Place) -> None:
        """A process could not be started there: nothing is, for a while."""
        with self._lock:
            place.barred_until = time.monotonic() + BARRED

    def run(self, work: Coroutine[Any, Any, AnyResult]) -> Future[AnyResult]:
        """Have it run on the loop."""
        return asyncio.run_coroutine_threadsafe(work, self._loop)

    def close(self) -> None:
        """Leave the cluster; its processes that have not been ended end by themselves."""
        self._keeping.cancel()
        with contextlib.suppress(Exception):
            self.run(self._leave()).result(_CLOSE_PATIENCE)
        self._stop()

    def _freest(self) -> Place | None:
        now = time.monotonic()
        free = [
            p for p in self._places.values() if self._taken[p] < p.threads and now >= p.barred_until
        ]
        return min(free, key=lambda p: self._taken[p] / p.threads, default=None)

    def _stop(self) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(_CLOSE_PATIENCE)

    # ---- on the loop

    async def actor(self, place: Place, origin: object) -> tuple[Any, Any]:
        """A copy of an object on a worker: dask's future, to be released, and the actor."""
        if self._client is None:
            raise ConnectionError("the cluster is lost")
        future = self._client.submit(
            # As bytes: the scheduler reads what it passes on, and need not have our code.
            pickle.loads,
            pickle.dumps(origin),
            key=f"llsrbm-{type(origin).__name__.lower()}-{uuid.uuid4().hex}",
            workers=[place.address],
            allow_other_workers=False,
            actor=True,
            priority=_PRIORITY,
        )
        try:
            return future, await future
        except BaseException:
            future.release()
            raise

    async def explain(self, place: Place, error: BaseException) -> tuple[str, bool]:
        """Why a process there may have been lost, and whether the terminal knows; looks first."""
        self._looked.clear()
        self._look_now.set()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_REASON_PATIENCE):
                await self._looked.wait()
        if self._client is None:
            return "the cluster was lost", True
        if place.gone.is_set():
            return f"its worker of the cluster, {place.address}, was lost", False
        return f"on the cluster's worker {place.address}: {_reason(error)}", False

    async def _connect(self) -> None:
        client = Client(self.address, asynchronous=True, timeout=CONNECT_PATIENCE)
        try:
            async with asyncio.timeout(CONNECT_PATIENCE):
                await client
            self._client = client
            await self._look()
        except BaseException:
            self._client = None
            await _close(client)
            raise

    async def _keep(self) -> None:
        while True:
            try:
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(LOOK_INTERVAL):
                        await self._look_now.wait()
                self._look_now.clear()
                await self._look()
            except Exception as error:  # noqa: BLE001  # by whatever exception dask says so
                _log.debug("lost: %r", error)
                await self._lost()
            self._looked.set()

    async def _lost(self) -> None:
        client, self._client = self._client, None
        self._meet({})
        self._looked.set()
        self._remark(
            f"The cluster at {self.address} is lost; the processes of the server's machine go on."
        )
        await _close(client)
        while self._client is None:
            await asyncio.sleep(RETRY_INTERVAL)
            with contextlib.suppress(Exception):
                await self._connect()
        self._remark(f"The cluster at {self.address} is back.")

    async def _look(self) -> None:
        client = self._client
        # Dask would connect anew by itself, but the objects on its workers would be gone.
        if client.status != "running":
            raise ConnectionError("the connection was closed")
        async with asyncio.timeout(LOOK_PATIENCE):
            seen = (await client.scheduler.identity())["workers"]
        self._unfit = {address: why for address, why in self._unfit.items() if address in seen}
        fit = {a: worker["nthreads"] for a, worker in seen.items() if a not in self._unfit}
        fit = await self._with_our_code(client, fit)
        self._meet(fit)
        self._changed()  # a worker may be barred no longer

    def _meet(self, fit: Mapping[str, int]) -> None:
        with self._lock:
            before = self._places
            self._places = {a: before.get(a) or Place(a, threads) for a, threads in fit.items()}
        for address, place in before.items():
            if address not in fit:
                place.gone.set()

    async def _with_our_code(self, client: Any, seen: dict[str, int]) -> dict[str, int]:
        new = [address for address in seen if address not in self._places]
        if not new:
            return seen
        answers: dict[str, Any] = {}
        with contextlib.suppress(TimeoutError):  # asked again at the next look
            async with asyncio.timeout(IDENTITY_PATIENCE):
                answers = await client.run(code_identity, workers=new, on_error="return")
        unfit = {a: self._misfit(answer) for a, answer in answers.items()}
        unfit = {address: why for address, why in unfit.items() if why}
        self._unfit |= unfit
        for why in dict.fromkeys(unfit.values()):
            which = [address for address, reason in unfit.items() if reason == why]
            others = f" and {len(which) - 1} more" if len(which) > 1 else ""
            self._remark(f"The cluster's worker {which[0]}{others} is not used: {why}.")
        fit = {a for a in answers if a not in unfit}
        return {a: threads for a, threads in seen.items() if a in fit or a not in new}

    def _misfit(self, answer: object) -> str:
        """Why a worker that answered this cannot be used; "" if it can."""
        if answer == self._identity:
            return ""
        if isinstance(answer, CodeIdentity):
            return f"it has {answer}, the server {self._identity}; expected the same wheel"
        return f"it cannot load the page's code ({_reason(answer)}); expected the server's wheel"

    async def _leave(self) -> None:
        client, self._client = self._client, None
        if client is not None:
            await _close(client)


async def _close(client: Any) -> None:
    with contextlib.suppress(Exception):
        async with asyncio.timeout(_CLOSE_PATIENCE):
            await client.close()


def _quieten() -> None:
    """Silence dask's own lines: what matters of them is a remark of ours, in one line."""
    for name in ("distributed", *dask.config.get("logging", {})):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)


def _reason(error: object) -> str:
    return " ".join(str(error).split())[:200] or type(error).__name__


def _ignore() -> None:
    pass
