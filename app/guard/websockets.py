"""Connections of the server: counted, their requests put before the guard, their pace limited.

The `websockets` library limits sizes and times (see `Door.options`); here are the other limits:
methods besides GET, floods of messages and of empty frames, tabs that send or read nothing.
"""

from __future__ import annotations

import asyncio
import logging
import socket
from collections import Counter
from collections.abc import Awaitable, Callable, Iterable
from functools import partial
from http import HTTPStatus
from typing import Any

import viser
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode, Frame, Opcode
from websockets.http11 import Request as SentRequest
from websockets.http11 import Response
from websockets.protocol import State
from websockets.typing import Data

from app.guard.limits import TokenBucket
from app.guard.policy import Guard, Header, Request

Handler = Callable[[ServerConnection], Awaitable[None]]

_VERSION = viser.__version__
_LONGEST_METHOD = 16  # bytes; those of HTTP have at most 7
_COUNTED_AS_ONE = 128 << 10  # bytes of a message
_WATCH_PERIOD = 1.0  # s

_log = logging.getLogger(__name__)


class Connection(ServerConnection):
    """A connection that keeps the limits of its door."""

    def __init__(self, door: Door, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._door, self._guard = door, door.guard
        limits = door.guard.limits
        self._head = b""
        self._messages, self._controls = TokenBucket(limits.messages), TokenBucket(limits.controls)
        self._slowed_since: float | None = None
        self._fragments = 0
        self.address = "unknown"  # of the other side
        self.peer = "unknown"  # that it counts as: of whom a proxy says that a request is
        self.method = self.host = ""  # of its request, once that begins, and if it is a known one
        self.silent = True  # nothing came since it was opened as a tab
        self.taken_at = self.loop.time()  # s, when it last took nearly all that was sent

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Count it."""
        address = transport.get_extra_info("peername")
        if address:
            self.address = str(address[0])
            self.peer = self._guard.peer_of(self.address)
        super().connection_made(transport)
        size = self._guard.limits.socket_bytes
        transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, size)
        self._door.enter(self)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget it."""
        self._door.leave(self)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Check the method first: websockets knows GET alone, and drops all others unanswered."""
        if not self.method:
            self._head += data
            method, space, rest = self._head.partition(b" ")
            if not space and len(method) <= _LONGEST_METHOD:
                return
            self.method = method.decode("ascii", "replace")
            if method not in (b"GET", b"HEAD"):
                self._refuse_method()
                return
            data, self._head = b"GET " + rest, b""
        elif self._head:
            return  # it was refused
        super().data_received(data)

    def _refuse_method(self) -> None:
        decision = self._guard.decide(Request(self.method, "/", {}, self.peer))
        self._guard.note(self.peer, decision.reason, self.method)
        if self.method.isascii() and self.method.isalpha():
            headers = (*decision.headers, *self._guard.headers(""))
            answer = _response(decision.status, decision.body.encode(), headers)
            self.transport.write(answer.serialize())
            self.transport.close()
        else:  # no HTTP, TLS for example
            self.transport.abort()

    def resume_writing(self) -> None:
        """Remember when there was room again."""
        self.taken_at = self.loop.time()
        super().resume_writing()

    def process_event(self, event: Any) -> None:
        """Count frames that never become a message."""
        if isinstance(event, Frame) and self.request is not None:
            if event.opcode in (Opcode.PING, Opcode.PONG) and not self._controls.take():
                self.cut("too many pings")
                return
            if event.opcode in (Opcode.TEXT, Opcode.BINARY, Opcode.CONT):
                self._fragments = 0 if event.fin else self._fragments + 1
                if self._fragments > self._guard.limits.fragments:
                    self.cut("message in too many fragments")
                    return
        super().process_event(event)

    async def recv(self, decode: bool | None = None) -> Data:  # type: ignore[override]
        """The next message, later if they come too fast: the rest waits in the network."""
        message = await super().recv(decode)
        self.silent = False
        wait = self._messages.wait(1 + len(message) / _COUNTED_AS_ONE)
        if wait <= 0.0:
            self._slowed_since = None
            return message
        now = self.loop.time()
        if self._slowed_since is None:
            self._slowed_since = now
        elif now - self._slowed_since > self._guard.limits.flood_s:
            self._guard.note(self.peer, "too many messages; closed")
            await self.close(CloseCode.POLICY_VIOLATION, "too many messages")
        await asyncio.sleep(wait)
        if self.state is State.CLOSED:  # thousands may have come before
            raise self.protocol.close_exc
        return message

    def cut(self, reason: str) -> None:
        """End it at once."""
        self._guard.note(self.peer, f"{reason}; closed")
        self.transport.abort()


class Door:
    """All connections of a server; on its event loop alone."""

    def __init__(
        self,
        guard: Guard,  # decides
        page: Callable[[bool], bytes],  # the page, compressed with gzip or not
        # bytes of messages that wait for a connection, about
        waiting: Callable[[ServerConnection], float],
        # true for an error by an unreadable message, false for a defect
        is_bad_message: Callable[[Exception], bool],
    ) -> None:
        self.guard = guard
        self.tabs: dict[Connection, None] = {}  # WebSockets that were let in, the oldest first
        # connections that are no tab, or not yet, the oldest first
        self.pending: dict[Connection, None] = {}
        self._page, self._waiting, self._is_bad_message = page, waiting, is_bad_message

    def options(self, handler: Handler) -> dict[str, Any]:
        """Arguments of `websockets.asyncio.server.serve`, in place of viser's."""
        limits = self.guard.limits

        async def handle(connection: ServerConnection) -> None:
            assert isinstance(connection, Connection)
            await self._handle(connection, handler)

        quiet = logging.Logger("websockets.server")  # noqa: LOG001  # `_defect` logs instead
        quiet.disabled = True
        return {
            "handler": handle,
            "process_request": self._answer,
            "process_response": self._complete,
            "server_header": None,
            "open_timeout": limits.open_s,
            "close_timeout": limits.close_s,
            "ping_interval": limits.stalled_s,
            "ping_timeout": limits.stalled_s,
            "max_size": limits.message_bytes,
            "logger": quiet,
            "create_connection": lambda *args, **kw: Connection(self, *args, **kw),
        }

    # ---- counting

    def enter(self, connection: Connection) -> None:
        """Count a new connection; in place of an old one if there are too many."""
        self.pending[connection] = None
        if len(self.pending) > self.guard.limits.pending:
            (most, _), *_ = Counter(each.peer for each in self.pending).most_common(1)
            oldest = next(each for each in self.pending if each.peer == most)
            self._drop(oldest, "too many connections at a time")

    def leave(self, connection: Connection) -> None:
        """Forget a connection."""
        self.pending.pop(connection, None)
        self.tabs.pop(connection, None)

    def _admit(self, connection: Connection) -> None:
        """Count a tab; in place of the oldest silent one if there are too many."""
        limits = self.guard.limits
        same = [each for each in self.tabs if each.peer == connection.peer]
        for tabs, most in ((same, limits.tabs_per_peer), ([*self.tabs], limits.tabs)):
            if len(tabs) >= most:
                silent = next((each for each in tabs if each.silent and each in self.tabs), None)
                if silent is not None:
                    self._drop(silent, "silent tab in place of which another came")
        self.pending.pop(connection, None)
        self.tabs[connection] = None

    def _drop(self, connection: Connection, reason: str) -> None:
        self.leave(connection)
        connection.cut(reason)

    # ---- requests

    async def _answer(self, connection: ServerConnection, sent: SentRequest) -> Response | None:
        assert isinstance(connection, Connection)
        try:
            delay, answer = self._decide(connection, sent)
        except Exception as error:
            self._defect(error)
            raise
        await asyncio.sleep(delay)
        return answer

    def _decide(self, connection: Connection, sent: SentRequest) -> tuple[float, Response | None]:
        forwarded = sent.headers.get_all("X-Forwarded-For")
        connection.peer = self.guard.peer_of(connection.address, forwarded)
        request = Request.of(
            connection.method, sent.path, sent.headers.raw_items(), connection.peer
        )
        talking = [tab for tab in self.tabs if not tab.silent]
        of_peer = sum(tab.peer == connection.peer for tab in talking)
        decision = self.guard.decide(request, len(talking), of_peer)
        if decision.reason:
            shown = ", ".join((*request.values("host"), *request.values("origin")))
            self.guard.note(connection.peer, decision.reason, shown)
        if decision.reason != "unknown host":
            connection.host = request.host
        if decision.status is HTTPStatus.SWITCHING_PROTOCOLS:
            self._admit(connection)
            return decision.delay, None
        if decision.status is HTTPStatus.OK and not decision.body:
            gzipped = "gzip" in ",".join(request.values("accept-encoding"))
            headers = {
                "Content-Type": "text/html; charset=utf-8",
                "Content-Encoding": "gzip" if gzipped else "identity",
                # The browser asks again each time: a new version must not meet an old page.
                "Cache-Control": "no-cache",
                "Vary": "Accept-Encoding, Cookie",
            }
            return decision.delay, _response(decision.status, self._page(gzipped), headers.items())
        kind = "html" if decision.html else "plain"
        content = ("Content-Type", f"text/{kind}; charset=utf-8")
        return decision.delay, _response(
            decision.status, decision.body.encode(), (content, *decision.headers)
        )

    def _complete(
        self, connection: ServerConnection, _: SentRequest, answer: Response
    ) -> Response | None:
        """All answers, those of websockets itself too."""
        assert isinstance(connection, Connection)
        for name, value in self.guard.headers(connection.host):
            answer.headers[name] = value
        if connection.method != "HEAD":
            return None
        return Response(answer.status_code, answer.reason_phrase, answer.headers, b"")

    # ---- tabs

    async def _handle(self, connection: Connection, handler: Handler) -> None:
        client = (connection.subprotocol or "").removeprefix("viser-v")
        if client != _VERSION:  # viser would print a line for each
            self.guard.note(connection.peer, "page of another version", client)
            # The page shows this sentence.
            reason = f"Version mismatch. Client: {client[:20]}, Server: {_VERSION}"
            await connection.close(CloseCode.PROTOCOL_ERROR, reason)
            return
        watching = asyncio.create_task(self._watch(connection))
        watching.add_done_callback(partial(self._watched, connection))
        try:
            await handler(connection)
        except (ConnectionClosed, OSError, EOFError):
            pass  # as browsers do at any time
        except Exception as error:
            if self._is_bad_message(error):
                reason = f"a tab sent what cannot be read ({type(error).__name__}); closed"
                self.guard.note(connection.peer, reason)
                await connection.close(CloseCode.INVALID_DATA, "message cannot be read")
            else:
                self._defect(error)
                raise
        finally:
            watching.cancel()
            await asyncio.wait([watching])

    def _watched(self, connection: Connection, watching: asyncio.Task[None]) -> None:
        """Log a failure of a watch, and end its tab, which would have no limits any more."""
        error = None if watching.cancelled() else watching.exception()
        if error is not None:
            self._defect(error)
            connection.cut("a tab could not be watched")

    async def _watch(self, connection: Connection) -> None:
        """Close a tab that sends nothing, or does not take the messages that wait for it."""
        limits, opened, size = self.guard.limits, connection.loop.time(), 0
        while True:
            await asyncio.sleep(_WATCH_PERIOD)
            now, before = connection.loop.time(), size
            size = connection.transport.get_write_buffer_size()
            if size == 0 or size < before:
                connection.taken_at = now
            if size + self._waiting(connection) > limits.backlog_bytes:
                connection.cut("too much waits for a tab")
            elif now - connection.taken_at > limits.stalled_s:
                connection.cut(f"a tab took nothing for {limits.stalled_s:g} s")
            elif connection.silent and now - opened > limits.first_message_s:
                connection.cut(f"a tab sent nothing for {limits.first_message_s:g} s")

    def _defect(self, error: BaseException) -> None:
        if self.guard.note("", f"the server ran into a defect ({type(error).__name__})"):
            _log.error("a connection ran into a defect", exc_info=error)


def _response(status: HTTPStatus, body: bytes, headers: Iterable[Header]) -> Response:
    """An answer, after which the connection ends, as it does after all of websockets'."""
    fields = Headers()
    fields["Connection"] = "close"
    fields["Content-Length"] = str(len(body))
    for name, value in headers:
        fields[name] = value
    return Response(status.value, status.phrase, fields, body)
