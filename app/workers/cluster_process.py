"""A computing process on a cluster, behind the same interface as one of this machine."""

from __future__ import annotations

import asyncio
import logging
import pickle
from concurrent.futures import Future
from dataclasses import dataclass
from multiprocessing.reduction import ForkingPickler
from typing import TYPE_CHECKING, Any

from app.workers.channel import Received, Sink
from app.workers.cluster_host import KEEP_ALIVE, Host, Message
from app.workers.planner import PlannerFactory
from app.workers.process import END_PATIENCE, KILL_PATIENCE, START_PATIENCE, Ended
from app.workers.protocol import Job

if TYPE_CHECKING:
    from app.workers.cluster import Cluster, Place

# How long a worker may take to answer beyond `KEEP_ALIVE` before it counts as lost, s: its loop, or
# the scheduler's, may be held up by other work.
ANSWER_PATIENCE = 15.0
# What its start may take in addition, s: the worker may have to finish a piece of a sweep first.
PLACE_PATIENCE = 120.0

_log = logging.getLogger(__name__)


@dataclass
class _Ending:
    """When to give up a process that shall end, s."""

    give_up_at: float
    unexpected: bool


class ClusterProcess:
    """See `app.workers.process.Process`.

    A conversation on the cluster's loop asks the process' host for messages, again and again, until
    it says that the process has ended, or does not answer any more.

    Attributes:
        id: of the process, on its machine; None while that is not known.
        channel: of the present process; None while there is none, or it is ending.
    """

    def __init__(self, cluster: Cluster, factory: PlannerFactory, inbox: Sink, name: str) -> None:
        """Nothing runs before `start`.

        Args:
            cluster: that it is to run on.
            factory: makes the planner inside the process.
            inbox: gets all that the process sends.
            name: of the process.
        """
        self._cluster = cluster
        self._factory = factory
        self._inbox = inbox
        self._name = name
        self._conversation: _Conversation | None = None
        self._ending: _Ending | None = None

    @property
    def id(self) -> int | None:
        """See `Process.id`."""
        return None if self._conversation is None else self._conversation.process_id

    @property
    def channel(self) -> object | None:
        """See `Process.channel`."""
        return None if self.ending else self._conversation

    @property
    def exists(self) -> bool:
        """See `Process.exists`."""
        return self._conversation is not None

    @property
    def ending(self) -> bool:
        """See `Process.ending`."""
        return self._ending is not None

    @property
    def startable(self) -> bool:
        """Whether the cluster has a place free."""
        return self._cluster.has_room

    @property
    def start_patience(self) -> float:
        """See `Process.start_patience`."""
        return START_PATIENCE + PLACE_PATIENCE

    def start(self) -> None:
        """See `Process.start`."""
        place = self._cluster.take()
        if place is None:
            raise OSError("no worker of the cluster is free")
        self._conversation = _Conversation(
            self._cluster, place, self._factory, self._inbox, self._name
        )

    def send(self, job: Job) -> None:
        """See `Process.send`."""
        if self._conversation is not None:
            self._conversation.tell("send", bytes(ForkingPickler.dumps(job)))

    def stop(self, number: int) -> None:
        """See `Process.stop`."""
        conversation = self._conversation
        if conversation is not None:
            conversation.tell("stop", number)

    def end(self, now: float, patience: float = 0.0, *, unexpected: bool = False) -> None:
        """See `Process.end`."""
        if self._conversation is None or self._ending is not None:
            return
        self._ending = _Ending(now + patience + END_PATIENCE + KILL_PATIENCE, unexpected)
        self._conversation.end(patience)

    def poll(self, now: float) -> Ended | None:
        """See `Process.poll`."""
        ending, conversation = self._ending, self._conversation
        if ending is None or conversation is None:
            return None
        ended = conversation.ended
        if ended is None:
            if now < ending.give_up_at:
                return None
            conversation.give_up()
            ended = Ended("its worker of the cluster does not answer", unexpected=True)
        self._conversation = self._ending = None
        return Ended(ended.how, ending.unexpected, ended.logged)

    def kill(self) -> None:
        """Leave it: it ends when it is not asked for messages any more."""
        if self._conversation is not None:
            self._conversation.give_up()


class _Conversation:
    """With one host, from the start of its process to its end; `Received.channel` of its messages.

    Attributes:
        process_id: of the process; None until it has been started.
        ended: how the process ended; None as long as it has not.
    """

    def __init__(
        self, cluster: Cluster, place: Place, factory: PlannerFactory, inbox: Sink, name: str
    ) -> None:
        """Begin it, on the cluster's loop."""
        self._cluster = cluster
        self._place = place
        self._factory = factory
        self._inbox = inbox
        self._name = name
        self._host: Any = None  # dask's proxy of a `Host`
        self._patience: float | None = None  # s that the process gets, once it shall end
        self._was_ready = False
        self.process_id: int | None = None
        self.ended: Ended | None = None
        self._future: Future[None] = cluster.run(self._converse())

    # ---- from any thread

    def tell(self, method: str, argument: object) -> None:
        """Have a method of the host called, if it is there; a host that has gone is noticed."""
        self._cluster.run(self._tell(method, argument))

    def end(self, patience: float) -> None:
        """Have the process end; `ended` says when it has."""
        self._patience = patience
        self.tell("end", patience)

    def give_up(self) -> None:
        """Ask for nothing any more."""
        self._future.cancel()

    # ---- on the cluster's loop

    async def _tell(self, method: str, argument: object) -> None:
        if self._host is not None:
            try:
                await self._ask(method, argument)
            except Exception as error:  # noqa: BLE001  # whatever is wrong, `_listen` meets it too
                _log.debug("%s cannot be told to %s: %s", self._name, method, error)

    async def _converse(self) -> None:
        ended = Ended("given up", unexpected=True)
        try:
            ended = await self._listen()
        except Exception as error:  # noqa: BLE001  # by whatever exception dask says so
            how, logged = await self._cluster.explain(self._place, error)
            ended = Ended(how, unexpected=True, logged=logged)
        finally:
            if not self._was_ready and self._patience is None:
                self._cluster.bar(self._place)
            self._cluster.give_back(self._place)
            self.ended = ended
            self._inbox.put(Received(self, None))

    async def _listen(self) -> Ended:
        origin = Host(self._factory, self._name)
        future, self._host = await self._cluster.actor(self._place, origin)
        try:
            if self._patience is None:
                self.process_id = await self._ask("start")
            if self._patience is not None:  # it was told to end before there was anything to end
                await self._tell("end", self._patience)
            while True:
                content = await self._ask("messages")
                messages: list[Message] = pickle.loads(content)  # noqa: S301  # of our own code
                for message in messages:
                    if isinstance(message, Ended):
                        return message
                    self._was_ready = True
                    self._inbox.put(Received(self, message))
        finally:
            future.release()

    async def _ask(self, method: str, *arguments: object) -> Any:
        """The host's answer.

        Raises:
            Exception: of the host, or because it is lost.
        """
        answer = asyncio.ensure_future(_awaited(getattr(self._host, method)(*arguments)))
        gone = asyncio.ensure_future(self._place.gone.wait())
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
