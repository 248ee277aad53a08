"""Everything that leans on viser's private parts; its test is the contract.

viser accepts any Host, any Origin and any number of connections, takes the next port when one is
in use, hangs when it cannot bind, and would open a public tunnel at any client's request.
"""

from __future__ import annotations

import contextlib
import io
import ipaddress
import logging
import warnings
from collections.abc import Collection, Iterator
from http import HTTPStatus
from typing import Any
from urllib.parse import urlsplit

import viser
import viser._messages
import websockets.asyncio.server
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from app.page_html import page_gzip, page_html

MAX_CONNECTIONS = 50
"""Tabs at a time; each costs a thread and some megabytes."""

_MAX_MESSAGE = 1 << 20  # bytes a browser may send at once; sliders and clicks are far smaller

_PAGE = ("/", "/index.html")

_log = logging.getLogger(__name__)

# A tab may close while a frame is under way; the session ends a moment later.
warnings.filterwarnings("ignore", message="Queued a .* on a closed connection", module="viser")


class DesignerServer(viser.ViserServer):
    """A viser server that only lets its own page in and never opens a tunnel."""

    def __init__(self, host: str, port: int, allowed_hosts: Collection[str]) -> None:
        """Bind and serve.

        Args:
            host: address to bind to; must be bindable, or this hangs.
            port: port to bind to; 0 takes any.
            allowed_hosts: names under which browsers may reach the page, besides plain addresses.
        """
        names = frozenset(name.lower() for name in allowed_hosts)
        with _guarded(names), silent():
            super().__init__(host=host, port=port, verbose=False)

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Refuse: a tunnel to an outside host is nothing a visitor may open."""
        _log.warning("a client asked for a share URL; refused")
        return None

    def stop(self) -> None:
        """Stop serving, without a word."""
        with silent():
            super().stop()


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
    client._websock_connection.queue_message(viser._messages.RunJavascriptMessage(source))


def refusal(
    host: str | None, origin: str | None, connections: int, allowed_hosts: Collection[str]
) -> str | None:
    """Why a request is refused, or None if it is welcome.

    A page of another site may make a browser connect here. It cannot hide its Origin, nor, when its
    own name resolves to this machine (DNS rebinding), the Host it believes to speak to.

    Args:
        host: the request's Host header.
        origin: its Origin header; browsers always send one with a WebSocket.
        connections: tabs that are connected.
        allowed_hosts: names besides plain addresses, lower case.
    """
    try:
        name = (urlsplit(f"//{host or ''}").hostname or "").lower()
        origin_host = urlsplit(origin).netloc.lower() if origin else None
    except ValueError:
        return "Host or Origin cannot be read"
    if name not in allowed_hosts and not _is_address(name):
        return f"unknown host {name!r}; start with --allow-host {name or 'NAME'} to serve it"
    if origin_host is not None and origin_host != (host or "").lower():
        return "request from another site"
    if connections >= MAX_CONNECTIONS:
        return f"too many open tabs (at most {MAX_CONNECTIONS})"
    return None


def uuid_of(handle: Any) -> str:
    """The name by which a page knows a control."""
    return str(handle._impl.uuid)


def _page(*, gzipped: bool) -> Response:
    body = page_gzip() if gzipped else page_html()
    headers = Headers(
        {
            "Content-Type": "text/html; charset=utf-8",
            "Content-Length": str(len(body)),
            "Content-Encoding": "gzip" if gzipped else "identity",
            # The browser asks again each time: a new version must not meet an old page.
            "Cache-Control": "no-cache",
        }
    )
    return Response(HTTPStatus.OK, "OK", headers, body)


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


@contextlib.contextmanager
def _guarded(allowed_hosts: frozenset[str]) -> Iterator[None]:
    """While a viser server is made: have its WebSocket server check every request first."""
    serve = websockets.asyncio.server.serve

    def guarded_serve(handler: Any, *args: Any, **options: Any) -> Any:
        answer = options.pop("process_request")

        def check_then_answer(connection: ServerConnection, request: Request) -> Response | None:
            upgrade = request.headers.get("Upgrade", "").lower() == "websocket"
            open_tabs = len(connection.server.connections) - 1 if upgrade else 0
            hosts, origins = (request.headers.get_all(key) for key in ("Host", "Origin"))
            why = (
                "ambiguous Host or Origin"
                if len(hosts) > 1 or len(origins) > 1
                else refusal(
                    hosts[0] if hosts else None,
                    origins[0] if origins else None,
                    open_tabs,
                    allowed_hosts,
                )
            )
            if why is None:
                if not upgrade and request.path.partition("?")[0] in _PAGE:
                    return _page(gzipped="gzip" in request.headers.get("Accept-Encoding", ""))
                response: Response | None = answer(connection, request)
                return response
            body = f"refused: {why}\n".encode()
            headers = Headers(
                {"Content-Type": "text/plain; charset=utf-8", "Content-Length": str(len(body))}
            )
            return Response(HTTPStatus.FORBIDDEN, "Forbidden", headers, body)

        options |= {"process_request": check_then_answer, "max_size": _MAX_MESSAGE}
        return serve(handler, *args, **options)

    websockets.asyncio.server.serve = guarded_serve  # type: ignore[assignment,misc]
    try:
        yield
    finally:
        websockets.asyncio.server.serve = serve  # type: ignore[misc]
