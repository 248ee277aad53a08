"""A computing process on a cluster, behind the same interface as one of this machine."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future
from multiprocessing.reduction import ForkingPickler
from typing import TYPE_CHECKING, Any

from app.workers.cluster_host import KEEP_ALIVE, Host, Message
from app.workers.process import Ended, Process
from app.workers.reports import Ready, Report
from app.workers.tasks import Job, PlannerFactory

if TYPE_CHECKING:
    from app.workers.cluster import Cluster, Place

# How long a worker may take to answer beyond `KEEP_ALIVE` before it counts as lost, s: its loop, or
# the scheduler's, may be held up by other work.
ANSWER_PATIENCE = 15.0
# Time that its start may take in addition, s: the worker may have to finish a piece of a sweep.
PLACE_PATIENCE = 120.0

_log = logging.getLogger(__name__)


class ClusterProcess(Process):
    """A `Process` whose `run` requests the messages of a `Host`, again and again."""

    start_patience = Process.start_patience + PLACE_PATIENCE

    def __init__(self, cluster: Cluster, factory: PlannerFactory, name: str) -> None:
        self._cluster, self._factory, self._name = cluster, factory, name
        self._host: Any = None  # dask's proxy of a `Host`
        self._starting: Future[Any] | None = None
        self._killed = False
        self._place: Place | None = None

    @property
    def startable(self) -> bool:
        return self._cluster.has_room

    def reserve(self) -> bool:
        self._place = self._cluster.take()
        return self._place is not None

    def run(self) -> Iterator[Ready | Report]:
        place = self._place
        assert place is not None
        self._killed, ready, future = False, False, None
        try:
            origin = Host(self._factory, self._name)
            self._starting = self._cluster.run(self._cluster.actor(place, origin))
            future, self._host = self._starting.result()
            self._call(place, "start")
            if self._killed:
                self._call(place, "kill")
            while True:
                messages: list[Message]
                self.id, messages = pickle.loads(self._call(place, "messages"))  # noqa: S301
                for message in messages:
                    if isinstance(message, Ended):
                        raise message
                    ready = True
                    yield message
        except Ended:
            raise
        except (Exception, CancelledError) as error:  # by whatever exception dask says so
            if self._killed:
                raise Ended("killed") from error
            how, logged = self._cluster.run(self._cluster.explain(place, error)).result()
            raise Ended(how, logged=logged) from error
        finally:
            self._host = self._starting = self.id = None
            if not ready and not self._killed:
                self._cluster.bar(place)
            if future is not None:
                future.release()
            self._cluster.give_back(place)

    def send(self, job: Job, failed: Callable[[Exception], None]) -> None:
        try:
            content = bytes(ForkingPickler.dumps(job))
        except Exception as error:  # noqa: BLE001  # whatever is wrong with it
            failed(error)
            return
        self._request("send", content)

    def stop(self, number: int) -> None:
        self._request("stop", number)

    def kill(self) -> None:
        self._killed = True
        if self._host is not None:
            self._request("kill")
        elif self._starting is not None:
            self._starting.cancel()

    def _call(self, place: Place, method: str) -> Any:
        return self._cluster.run(_answer(place, getattr(self._host, method))).result()

    def _request(self, method: str, *arguments: object) -> None:
        host = self._host
        if host is not None:
            self._cluster.run(_quietly(getattr(host, method), arguments))


async def _quietly(method: Callable[..., Any], arguments: tuple[object, ...]) -> None:
    with contextlib.suppress(Exception):
        await method(*arguments)


async def _answer(place: Place, method: Callable[[], Any]) -> Any:
    answer = asyncio.ensure_future(_awaited(method()))
    gone = asyncio.ensure_future(place.gone.wait())
    try:
        async with asyncio.timeout(KEEP_ALIVE + ANSWER_PATIENCE):
            await asyncio.wait({answer, gone}, return_when=asyncio.FIRST_COMPLETED)
        if not answer.done():
            raise ConnectionError("the worker has gone")
        return answer.result()
    finally:
        gone.cancel()
        answer.cancel()


async def _awaited(answer: Any) -> Any:
    return await answer
