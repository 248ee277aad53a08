"""One connection to the server, from its first byte on, and the door it has to pass.

websockets speaks the protocol; here is what it leaves open: methods other than GET, requests that
never end, how many connections there are of which kind, tabs that send faster than a page can, and
tabs that do not read.
"""

from __future__ import annotations

import asyncio
import logging
import socket
from collections import Counter
from collections.abc import Awaitable, Callable
from http import HTTPStatus
from typing import Any

import viser
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed, WebSocketException
from websockets.frames import CloseCode, Frame, Opcode
from websockets.http11 import Request, Response
from websockets.protocol import State
from websockets.typing import Data

from app.viser_link import entry
from app.viser_link.backlog import watch
from app.viser_link.limits import TokenBucket
from app.viser_link.messages import is_bad_message

Handler = Callable[[ServerConnection], Awaitable[None]]

_LONGEST_METHOD = 16  # bytes; those of HTTP have at most 7
_VERSION = viser.__version__
_LEFT = (ConnectionClosed, OSError, EOFError)  # by these websockets says that a peer went away


class Door:
    """All connections of a server, and what its gate has to decide about them.

    Lives on the server's event loop.

    Attributes:
        tabs: WebSockets that are open.
        admitted: those, and the ones that were let in and are about to open.
        pending: connections that are no tab, or not yet.
        opened: whether a server was made with it.
    """

    def __init__(
        self,
        gate: entry.Gate,
        page: Callable[[bool], bytes],
        backlog: Callable[[ServerConnection], Any],
    ) -> None:
        """Guard a server that is about to be made.

        Args:
            gate: decides.
            page: the page, compressed with gzip or not.
            backlog: viser's queue of messages for a connection.
        """
        self.gate = gate
        self.tabs: set[ServerConnection] = set()
        self.admitted: set[ServerConnection] = set()
        self.pending: set[ServerConnection] = set()
        self.opened = False
        self._per_peer: Counter[str] = Counter()
        self._page = page
        self._backlog = backlog

    def options(self, handler: Handler) -> dict[str, Any]:
        """Arguments of `websockets.asyncio.server.serve`, in place of viser's."""
        self.opened = True
        limits = self.gate.limits

        async def handle(connection: ServerConnection) -> None:
            await self._handle(connection, handler)

        return {
            "handler": handle,
            "process_request": self._answer,
            "process_response": self._complete,
            "server_header": None,
            "open_timeout": limits.answer_s,
            "close_timeout": limits.close_s,
            "max_size": limits.message_bytes,
            "logger": self._logger(),
            "create_connection": lambda *args, **kw: GuardedConnection(self, *args, **kw),
        }

    # ---- counting

    def enter(self, connection: GuardedConnection) -> bool:
        """Count a new connection; false if there are too many of its peer, or in all."""
        self.pending.add(connection)
        self._per_peer[connection.peer] += 1
        limits = self.gate.limits
        if (
            len(self.pending) > limits.pending
            or self._per_peer[connection.peer] > limits.pending_per_peer
        ):
            self.gate.note(connection.peer, "too many connections at a time")
            return False
        return True

    def settle(self, connection: ServerConnection) -> None:
        """It is pending no more."""
        if connection in self.pending:
            self.pending.remove(connection)
            peer = connection.peer if isinstance(connection, GuardedConnection) else ""
            self._per_peer[peer] -= 1
            if not self._per_peer[peer]:
                del self._per_peer[peer]

    def leave(self, connection: ServerConnection) -> None:
        """It is gone, in whichever way."""
        self.settle(connection)
        self.tabs.discard(connection)
        self.admitted.discard(connection)

    # ---- requests

    def _answer(self, connection: ServerConnection, sent: Request) -> Response | None:
        assert isinstance(connection, GuardedConnection)
        request = entry.Request.of(
            connection.method, sent.path, sent.headers.raw_items(), connection.peer
        )
        decision = self.gate.decide(request, len(self.admitted))
        if decision.reason:
            host = request.host if decision.reason != "unknown host" else ""
            shown = ", ".join((*request.values("host"), *request.values("origin")))
            self.gate.note(connection.peer, decision.reason, shown)
        else:
            host = request.host
        connection.host = host
        if decision.status is HTTPStatus.SWITCHING_PROTOCOLS:
            self.admitted.add(connection)
            return None
        if decision.status is HTTPStatus.OK and not decision.body:
            gzipped = "gzip" in ",".join(request.values("accept-encoding"))
            body = self._page(gzipped)
            headers = {
                "Content-Type": "text/html; charset=utf-8",
                "Content-Encoding": "gzip" if gzipped else "identity",
                # The browser asks again each time: a new version must not meet an old page.
                "Cache-Control": "no-cache",
                "Vary": "Accept-Encoding, Cookie",
            }
            return _response(decision.status, body, headers.items())
        kind = "html" if decision.html else "plain"
        content = ("Content-Type", f"text/{kind}; charset=utf-8")
        return _response(decision.status, decision.body.encode(), (content, *decision.headers))

    def _complete(
        self, connection: ServerConnection, _: Request, response: Response
    ) -> Response | None:
        """Whatever is answered, by websockets itself too."""
        assert isinstance(connection, GuardedConnection)
        for name, value in self.gate.headers(connection.host):
            response.headers[name] = value
        if connection.method != "HEAD":
            return None
        return Response(response.status_code, response.reason_phrase, response.headers, b"")

    # ---- tabs

    async def _handle(self, connection: ServerConnection, handler: Handler) -> None:
        assert isinstance(connection, GuardedConnection)
        self.settle(connection)
        client = (connection.subprotocol or "").removeprefix("viser-v")
        if client != _VERSION:  # viser would print a line for each
            self.gate.note(connection.peer, "page of another version", client)
            # The page shows this sentence.
            reason = f"Version mismatch. Client: {client[:20]}, Server: {_VERSION}"
            await connection.close(CloseCode.PROTOCOL_ERROR, reason)
            return
        self.tabs.add(connection)
        watching = asyncio.create_task(
            watch(connection, lambda: self._backlog(connection), self.gate)
        )
        try:
            await handler(connection)
        except Exception as error:
            if not is_bad_message(error):
                raise
            reason = f"a tab sent what cannot be read ({type(error).__name__}); closed"
            self.gate.note(connection.peer, reason)
            await connection.close(CloseCode.INVALID_DATA, "message cannot be read")
        finally:
            watching.cancel()
            self.tabs.discard(connection)

    def _logger(self) -> logging.Logger:
        """websockets' own log, without what is the other side's doing."""
        logger = logging.Logger("websockets.server")  # noqa: LOG001  # not for all servers
        logger.parent = logging.getLogger("websockets.server")
        logger.addFilter(self._is_ours)
        return logger

    def _is_ours(self, record: logging.LogRecord) -> bool:
        connection = getattr(record, "websocket", None)
        error = record.exc_info[1] if record.exc_info else None
        if not isinstance(connection, GuardedConnection) or error is None:
            return True
        reason = f"{record.getMessage()} ({type(error).__name__})"
        if isinstance(error, _LEFT) or isinstance(error.__cause__, _LEFT):
            return False  # as browsers do at any time
        if isinstance(error, WebSocketException):
            self.gate.note(connection.peer, reason)
            return False
        return self.gate.note("", reason)  # a defect of ours, told in full once


class GuardedConnection(ServerConnection):
    """A connection that keeps the limits of its door.

    Attributes:
        peer: the other side's address.
        method: of its request, once that begins.
        began: whether anything came.
        host: of its request, if it is a known one.
        drained_at: s, on the loop's clock, when it last took all that was sent.
    """

    def __init__(self, door: Door, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        limits = door.gate.limits
        self._door, self._gate = door, door.gate
        self._head = b""
        self._messages, self._controls = TokenBucket(limits.messages), TokenBucket(limits.controls)
        self._slowed_since: float | None = None
        self._fragments = 0
        self._deadline: asyncio.TimerHandle | None = None
        self.peer, self.method, self.host = "unknown", "", ""
        self.began = False
        self.drained_at = self.loop.time()

    # ---- asyncio's side

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Count it, and give it some seconds to say what it wants."""
        address = transport.get_extra_info("peername")
        self.peer = str(address[0]) if address else "unknown"
        super().connection_made(transport)
        if not self._door.enter(self):
            self.transport.abort()
            return
        end = transport.get_extra_info("socket")
        end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, self._gate.limits.socket_bytes)
        self._deadline = self.loop.call_later(self._gate.limits.request_s, self._waited_enough)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget it."""
        if self._deadline is not None:
            self._deadline.cancel()
        self._door.leave(self)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Look at the method first: websockets knows GET alone, and drops all others unanswered."""
        self.began = True
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
        if self.request is not None and self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _waited_enough(self) -> None:
        if self.request is None:
            if self.began:
                self._gate.note(self.peer, "request that does not end")
            self.transport.abort()

    def _refuse_method(self) -> None:
        request = entry.Request(self.method, "/", {}, self.peer)
        decision = self._gate.decide(request, 0)
        self._gate.note(self.peer, decision.reason, self.method)
        if self.method.isascii() and self.method.isalpha():
            headers = (*decision.headers, *self._gate.headers(""))
            response = _response(decision.status, decision.body.encode(), headers)
            self.transport.write(response.serialize())
            self.transport.close()
        else:  # no HTTP, TLS for example
            self.transport.abort()

    # ---- websockets' side

    def process_event(self, event: Any) -> None:
        """Count what never becomes a message."""
        if self.request is not None and isinstance(event, Frame):
            if event.opcode in (Opcode.PING, Opcode.PONG):
                if not self._controls.take():
                    self._cut("too many pings")
                    return
            elif event.opcode in (Opcode.TEXT, Opcode.BINARY, Opcode.CONT):
                self._fragments = 0 if event.fin else self._fragments + 1
                if self._fragments > self._gate.limits.fragments:
                    self._cut("message in too many fragments")
                    return
        super().process_event(event)

    async def recv(self, decode: bool | None = None) -> Data:  # type: ignore[override]
        """The next message, later if they come too fast: the rest waits in the network."""
        message = await super().recv(decode)
        wait = self._messages.wait()
        if wait <= 0.0:
            self._slowed_since = None
            return message
        now = self.loop.time()
        if self._slowed_since is None:
            self._slowed_since = now
        elif now - self._slowed_since > self._gate.limits.flood_s:
            self._gate.note(self.peer, "too many messages; closed")
            await self.close(CloseCode.POLICY_VIOLATION, "too many messages")
        await asyncio.sleep(wait)
        if self.state is State.CLOSED:  # thousands may have come before
            raise self.protocol.close_exc
        return message

    async def send(self, message: Any, text: bool | None = None) -> None:
        """Send, and remember when it was taken."""
        await super().send(message, text)
        self.drained_at = self.loop.time()

    def _cut(self, reason: str) -> None:
        self._gate.note(self.peer, f"{reason}; closed")
        self.transport.abort()


def _response(status: HTTPStatus, body: bytes, headers: Any) -> Response:
    """Of which the connection ends, as with all of websockets'."""
    fields = Headers()
    fields["Connection"] = "close"
    fields["Content-Length"] = str(len(body))
    for name, value in headers:
        fields[name] = value
    return Response(status.value, status.phrase, fields, body)
