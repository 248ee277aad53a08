"""viser's server behind a door of ours; its test is the contract with viser's private parts.

viser accepts any Host, any Origin and any number of connections, takes the next port when one is
in use, hangs when it cannot bind, would open a public tunnel at any client's request, and keeps
whatever is uploaded to any control.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Iterator
from typing import Any

import viser
import viser._messages as messages
import websockets.asyncio.server
from viser.infra import WebsockClientConnection
from websockets.asyncio.server import ServerConnection

from app.guard.connection import GuardedConnection
from app.guard.door import Door
from app.guard.entry import Gate
from app.guard.messages import ignore_nonsense
from app.guard.uploads import UPLOAD_MESSAGES, Uploads

_TUNNEL = (messages.ShareUrlRequest, messages.ShareUrlDisconnect)


class DesignerServer(viser.ViserServer):
    """A viser server that only lets in whom its gate does, and never opens a tunnel."""

    def __init__(self, host: str, port: int, gate: Gate, page: Callable[[bool], bytes]) -> None:
        """Bind and serve.

        Args:
            host: address to bind to; must be bindable, or this hangs.
            port: port to bind to; 0 takes any.
            gate: decides about every request.
            page: the page, compressed with gzip or not.
        """
        self.gate = gate
        self.door = Door(gate, page, self._queue)
        with _behind(self.door), silent():
            super().__init__(host=host, port=port, verbose=False)
        ignore_nonsense(self._websock_server, gate, self._peer)
        self._websock_server.on_client_connect(self._ignore_nonsense)
        for kind in UPLOAD_MESSAGES:  # to controls that all tabs share: there are none
            self._websock_server.unregister_handler(kind)
        for request in _TUNNEL:
            self._websock_server.unregister_handler(request)
            self._websock_server.register_handler(request, self._refuse_tunnel)
        uploads = Uploads(gate.limits.upload_bytes)
        self.on_client_connect(uploads.guard)
        self.on_client_disconnect(uploads.forget)

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Refuse: a tunnel to an outside host is nothing a visitor may open."""
        return None

    def stop(self) -> None:
        """Stop serving, without a word."""
        with silent():
            super().stop()

    def _ignore_nonsense(self, client: WebsockClientConnection) -> None:
        ignore_nonsense(client, self.gate, self._peer)

    def _peer(self, client_id: int) -> str:
        connection = self._websock_server._live_connections.get(client_id)
        return connection.peer if isinstance(connection, GuardedConnection) else "a tab"

    def _refuse_tunnel(self, client_id: int, _: Any) -> None:
        self.gate.note(self._peer(client_id), "a tab asked for a tunnel")

    def _queue(self, connection: ServerConnection) -> Any:
        """viser's queue of messages for a connection; None before and after."""
        server = self._websock_server
        for client_id, live in tuple(server._live_connections.items()):
            if live is connection:
                state = server._client_state_from_id.get(client_id)
                return None if state is None else state.message_buffer
        return None


@contextlib.contextmanager
def silent() -> Iterator[None]:
    """viser prints boxes whatever `verbose` says; the terminal gets our one line instead."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield


def run_javascript(client: viser.ClientHandle, source: str) -> None:
    """Have one tab run a script, after whatever was sent to it before.

    Args:
        client: the tab.
        source: the script; it must not contain what a visitor wrote.
    """
    client._websock_connection.queue_message(messages.RunJavascriptMessage(source))


def uuid_of(handle: Any) -> str:
    """The name by which a page knows a control."""
    return str(handle._impl.uuid)


@contextlib.contextmanager
def _behind(door: Door) -> Iterator[None]:
    """While a viser server is made: put its WebSocket server behind a door.

    viser's own answers to requests, which would serve files, are never asked for.
    """
    serve = websockets.asyncio.server.serve

    def serve_behind_door(handler: Any, *args: Any, **options: Any) -> Any:
        options |= door.options(handler)
        return serve(options.pop("handler"), *args, **options)

    websockets.asyncio.server.serve = serve_behind_door  # type: ignore[assignment,misc]
    try:
        yield
    finally:
        websockets.asyncio.server.serve = serve  # type: ignore[misc]
