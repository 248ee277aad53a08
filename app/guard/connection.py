"""One connection to the server, from its first byte on.

websockets speaks the protocol; here is what it leaves open: methods other than GET, requests that
never end, and tabs that send faster than a page can.
"""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Iterable
from http import HTTPStatus
from typing import TYPE_CHECKING, Any

from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.frames import CloseCode, Frame, Opcode
from websockets.http11 import Response
from websockets.protocol import State
from websockets.typing import Data

from app.guard import entry
from app.guard.limits import TokenBucket

if TYPE_CHECKING:
    from app.guard.door import Door

_LONGEST_METHOD = 16  # bytes; those of HTTP have at most 7


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
            answer = response(decision.status, decision.body.encode(), headers)
            self.transport.write(answer.serialize())
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


def response(status: HTTPStatus, body: bytes, headers: Iterable[tuple[str, str]]) -> Response:
    """An answer, after which the connection ends, as it does after all of websockets'."""
    fields = Headers()
    fields["Connection"] = "close"
    fields["Content-Length"] = str(len(body))
    for name, value in headers:
        fields[name] = value
    return Response(status.value, status.phrase, fields, body)
