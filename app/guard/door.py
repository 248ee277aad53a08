"""The door of the server: its connections counted, their requests put before the gate.

Tabs are watched while they are open, and what ends a connection is noted down once.
"""

from __future__ import annotations

import asyncio
import logging
from collections import Counter
from collections.abc import Awaitable, Callable
from http import HTTPStatus
from typing import Any

import viser
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed, WebSocketException
from websockets.frames import CloseCode
from websockets.http11 import Request, Response

from app.guard import entry
from app.guard.backlog import watch
from app.guard.connection import GuardedConnection, response
from app.guard.messages import is_bad_message

Handler = Callable[[ServerConnection], Awaitable[None]]

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
            return response(decision.status, body, headers.items())
        kind = "html" if decision.html else "plain"
        content = ("Content-Type", f"text/{kind}; charset=utf-8")
        return response(decision.status, decision.body.encode(), (content, *decision.headers))

    def _complete(
        self, connection: ServerConnection, _: Request, answer: Response
    ) -> Response | None:
        """All answers, those of websockets itself too."""
        assert isinstance(connection, GuardedConnection)
        for name, value in self.gate.headers(connection.host):
            answer.headers[name] = value
        if connection.method != "HEAD":
            return None
        return Response(answer.status_code, answer.reason_phrase, answer.headers, b"")

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
