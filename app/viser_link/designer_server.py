"""Everything that leans on viser's private parts; its test is the contract.

viser accepts any Host, any Origin and any number of connections, takes the next port when one is
in use, hangs when it cannot bind, would open a public tunnel at any client's request, and keeps
whatever is uploaded to any control.
"""

from __future__ import annotations

import asyncio
import contextlib
import io
import ipaddress
import logging
import math
import traceback
import warnings
from collections.abc import Collection, Iterator
from http import HTTPStatus
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import viser
import viser._messages as messages
import websockets.asyncio.server
from viser.infra import Message, WebsockMessageHandler
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.frames import CloseCode
from websockets.http11 import Request, Response

from app.server.page_template import page_gzip, page_html

MAX_CONNECTIONS = 50
"""Tabs at a time; each costs a thread and some megabytes."""

UPLOAD_PART = 512 * 1024
"""Bytes of an uploaded file that come at once, as viser's page sends them."""

MAX_UPLOAD = 40 * UPLOAD_PART
"""Bytes of an uploaded file; a simulation of some seconds takes a twentieth of it."""

_ALL_UPLOADS = 3 * MAX_UPLOAD  # bytes that all tabs together may be sending
_TOO_LARGE = "application/x-too-large"  # the type by which the page says so, of nothing

_MAX_MESSAGE = 1 << 20  # bytes a browser may send at once; sliders and clicks are far smaller
_LONGEST_NAME = 255  # characters of an uploaded file's name, or of an identifier
_SETTLING = 0.3  # s until a page has drawn what an upload's end makes it draw

_PAGE = ("/", "/index.html")
_VISER = str(Path(viser.__file__).parent)

_log = logging.getLogger(__name__)

# A tab may close while a frame is under way; the session ends a moment later.
warnings.filterwarnings("ignore", message="Queued a .* on a closed connection")
# What is said of a message's shape repeats all of it, up to a megabyte.
warnings.filterwarnings("ignore", message=r"\[viser\] .* does not match annotation")


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
        _tell_nonsense_briefly(self._websock_server)
        self._websock_server.on_client_connect(_tell_nonsense_briefly)
        for kind in _UPLOADS:  # to controls that all tabs share: there are none
            self._websock_server.unregister_handler(kind)
        uploads = _Uploads()
        self.on_client_connect(uploads.guard)
        self.on_client_disconnect(uploads.forget)

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
    client._websock_connection.queue_message(messages.RunJavascriptMessage(source))


# ---- uploads

_UPLOADS = (messages.FileTransferStartUpload, messages.FileTransferPart)


class _Uploads:
    """What all tabs are sending; on the server's event loop alone.

    viser would keep the parts of any number of files of any size, sent to any control.
    """

    def __init__(self) -> None:
        self._announced: dict[int, int] = {}  # tab -> bytes of the file that it is sending

    async def guard(self, client: viser.ClientHandle) -> None:
        """Before a tab has any control: let only files through that are not too large."""
        connection, gui = client._websock_connection, client.gui

        # What a message holds is of any type, whatever its class says.
        async def start(client_id: Any, message: Any) -> None:
            button = gui._gui_input_handle_from_uuid.get(str(message.source_component_uuid))
            names = (message.transfer_uuid, message.filename, message.mime_type)
            if not isinstance(button, viser.GuiUploadButtonHandle) or not all(
                isinstance(name, str) and len(name) <= _LONGEST_NAME for name in names
            ):
                return
            gui._drop_uploads_from_client(client_id)  # one at a time
            self._announced.pop(client.client_id, None)
            size, parts = message.size_bytes, message.part_count
            right = isinstance(size, int) and parts == math.ceil(size / UPLOAD_PART)
            if not right or not 0 <= size <= MAX_UPLOAD or message.mime_type == _TOO_LARGE:
                await _refuse_upload(
                    client, message, f"too large; expected at most {MAX_UPLOAD >> 20} MB"
                )
            elif size + sum(self._announced.values()) > _ALL_UPLOADS:
                await _refuse_upload(
                    client, message, "too much is being sent by others; try again in a moment"
                )
            else:
                self._announced[client.client_id] = size
                gui._handle_file_transfer_start(client_id, message)
                self._look_whether_done(client)

        def part(client_id: Any, message: Any) -> None:
            if not isinstance(message.transfer_uuid, str) or not isinstance(message.content, bytes):
                return
            state = gui._current_file_upload_states.get(message.transfer_uuid)
            index = message.part_index
            if state is None or not isinstance(index, int) or index < 0:
                return
            left = state["total_bytes"] - index * UPLOAD_PART
            if len(message.content) == min(left, UPLOAD_PART):
                gui._handle_file_transfer_part(client_id, message)
                self._look_whether_done(client)

        for kind in _UPLOADS:
            connection.unregister_handler(kind)
        connection.register_handler(messages.FileTransferStartUpload, start)
        connection.register_handler(messages.FileTransferPart, part)

    async def forget(self, client: viser.ClientHandle) -> None:
        """The tab has gone."""
        self._announced.pop(client.client_id, None)

    def _look_whether_done(self, client: viser.ClientHandle) -> None:
        if not client.gui._current_file_upload_states:
            self._announced.pop(client.client_id, None)


_NO_FILE = viser.UploadedFile("", b"")


def take_upload(button: viser.GuiUploadButtonHandle) -> viser.UploadedFile | None:
    """The file that came last, if it was not taken before.

    The button lets go of it: viser would keep it as long as the tab is open.
    """
    file = button.value
    button._impl.value = _NO_FILE
    return None if file is _NO_FILE or not isinstance(file, viser.UploadedFile) else file


async def _refuse_upload(client: viser.ClientHandle, message: Any, why: str) -> None:
    """Say so, and end the page's progress bar: it goes on sending, and nothing is kept."""
    size = message.size_bytes if isinstance(message.size_bytes, int) else 0
    client._websock_connection.queue_message(
        messages.FileTransferPartAck(
            source_component_uuid=message.source_component_uuid,
            transfer_uuid=message.transfer_uuid,
            transferred_bytes=max(size, 0),
            total_bytes=max(size, 0),
        )
    )
    client.add_notification("Not opened", f"{message.filename}: {why}", color="orange")
    # The page announces a success at the end of every upload.
    await asyncio.sleep(_SETTLING)
    client._websock_connection.queue_message(
        messages.RemoveNotificationMessage(f"upload-{message.transfer_uuid}")
    )


# ---- requests and messages


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


def _tell_nonsense_briefly(handler: WebsockMessageHandler) -> None:
    """Log one line where viser fails at a message; asyncio would print all that was sent."""
    handle = handler._handle_incoming_message

    async def handle_briefly(client_id: Any, message: Message) -> None:
        try:
            await handle(client_id, message)
        except Exception as error:
            frames = traceback.extract_tb(error.__traceback__)[1:]
            if not all(frame.filename.startswith(_VISER) for frame in frames):
                raise  # a defect of this page
            kinds = type(message).__name__, type(error).__name__
            _log.warning("a tab sent a %s that makes no sense (%s); ignored", *kinds)

    handler._handle_incoming_message = handle_briefly  # type: ignore[method-assign]


def _is_bad_message(error: Exception) -> bool:
    """Whether a connection ended because what arrived on it is no message of viser's."""
    return any(
        frame.name == "_message_consumer" for frame in traceback.extract_tb(error.__traceback__)
    )


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

        async def handle(connection: ServerConnection) -> None:
            try:
                await handler(connection)
            except Exception as error:
                if not _is_bad_message(error):
                    raise
                _log.warning("a tab sent what cannot be read (%s); closed", type(error).__name__)
                await connection.close(CloseCode.INVALID_DATA, "message cannot be read")

        options |= {"process_request": check_then_answer, "max_size": _MAX_MESSAGE}
        return serve(handle, *args, **options)

    websockets.asyncio.server.serve = guarded_serve  # type: ignore[assignment,misc]
    try:
        yield
    finally:
        websockets.asyncio.server.serve = serve  # type: ignore[misc]
