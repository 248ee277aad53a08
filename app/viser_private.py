"""viser's server behind a guard; the only module that uses private parts of viser.

viser accepts any Host, any Origin and any number of connections, takes the next port when one is
in use, hangs when it cannot bind, would open a public tunnel at any client's request, and keeps
every file and value that is sent to any control. Its test is the contract with these parts.
"""

import asyncio
import contextlib
import dataclasses
import io
import math
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import viser
import viser._messages as messages
import websockets.asyncio.server
from viser.infra import WebsockClientConnection
from websockets.asyncio.server import ServerConnection

from app.guard.limits import LONGEST_TEXT, MAX_UPLOAD, UPLOAD_PART
from app.guard.policy import Guard
from app.guard.uploads import Uploads
from app.guard.websockets import Connection, Door

_VISER = str(Path(viser.__file__).parent)
_TOO_LARGE = (
    "application/x-too-large"  # an empty file of this type stands for one that is too large
)
_LONGEST_NAME = 255  # characters of an uploaded file's name, or of an identifier
_SETTLING = 0.3  # s until a page has drawn the success that it announces at every upload's end
_OBJECT = 100  # bytes of a number, or of anything that holds others, about
_IDLE_PERIOD = 1.0  # s between checks for uploads that wait too long
_NO_FILE = viser.UploadedFile("", b"")

# A tab may close while a frame is under way; the session ends a moment later.
warnings.filterwarnings("ignore", message="Queued a .* on a closed connection")
# A remark on a message's shape repeats all of it, up to a megabyte.
warnings.filterwarnings("ignore", message=r"\[viser\] .* does not match annotation")


class DesignerServer(viser.ViserServer):
    """A viser server that its guard protects, and that never opens a tunnel."""

    def __init__(self, host: str, port: int, guard: Guard, page: Callable[[bool], bytes]) -> None:
        """Bind to a bindable address (another hangs), port 0 is any; `page`: gzipped or not."""
        self.guard = guard
        self.door = Door(guard, page, self._waiting, _is_bad_message)
        self._uploads = Uploads(guard.limits)
        with _behind(self.door), silent():
            super().__init__(host=host, port=port, verbose=False)
        # Controls and scene belong to tabs: nothing that tabs send is for all of them.
        self._websock_server._incoming_handlers.clear()
        self._websock_server.on_client_connect(self._filter_messages)
        self.on_client_connect(self._accept_files)
        self.on_client_disconnect(self._forget)

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Refuse: no visitor may open a tunnel to an outside host."""
        return None

    def stop(self) -> None:
        """Stop serving, without a word."""
        with silent():
            super().stop()

    # ---- messages

    def _filter_messages(self, connection: WebsockClientConnection) -> None:
        """Drop a tab's messages that are too large, and note once where viser fails at one."""
        handle = connection._handle_incoming_message

        async def handle_filtered(client_id: Any, message: Any) -> None:
            kind = type(message).__name__
            if not self._let_through(client_id, message):
                self.guard.note(self._peer(client_id), f"a tab sent too much in a {kind}; ignored")
                return
            try:
                await handle(client_id, message)
            except Exception as error:
                failure = type(error).__name__
                frames = traceback.extract_tb(error.__traceback__)[1:]
                if all(frame.filename.startswith(_VISER) for frame in frames):
                    reason = f"a tab sent a {kind} that makes no sense ({failure}); ignored"
                    self.guard.note(self._peer(client_id), reason)
                elif self.guard.note("", f"{kind} ran into a defect ({failure})"):
                    raise  # logged in full once

        connection._handle_incoming_message = handle_filtered  # type: ignore[method-assign]

    def _let_through(self, client_id: int, message: Any) -> bool:
        """True if a message is small; of a control's update only its value is left."""
        most = self.guard.limits.value_bytes
        if isinstance(message, messages.FileTransferPart):
            return True  # `_accept_files` looks at it
        updates = getattr(message, "updates", None)
        if not isinstance(message, messages.GuiUpdateMessage) or not isinstance(updates, dict):
            return size_of(message, 2 * most) <= 2 * most
        message.updates = {k: v for k, v in updates.items() if k == "value"}
        client = self._connected_clients.get(client_id)
        control = client and client.gui._gui_input_handle_from_uuid.get(str(message.uuid))
        if isinstance(control, viser.GuiTextHandle) and not control.visible:
            most = LONGEST_TEXT  # by which the page's scripts answer
        return size_of(message.updates.get("value"), most) <= most

    def _peer(self, client_id: int) -> str:
        connection = self._websock_server._live_connections.get(client_id)
        return connection.peer if isinstance(connection, Connection) else "a tab"

    def _waiting(self, connection: ServerConnection) -> float:
        """Bytes of messages that wait in viser's queue for a connection, about."""
        server = self._websock_server
        for client_id, live in tuple(server._live_connections.items()):
            state = server._client_state_from_id.get(client_id) if live is connection else None
            if state is not None and state.message_buffer.message_from_id:
                with state.message_buffer.buffer_lock:
                    waiting = [*state.message_buffer.message_from_id.values()]
                return size_of(waiting, self.guard.limits.backlog_bytes)
        return 0.0

    # ---- files

    async def _accept_files(self, client: viser.ClientHandle) -> None:
        """Before a tab has any control: accept files to upload buttons alone, one at a time."""
        connection, gui = client._websock_connection, client.gui
        peer = self._peer(client.client_id)

        # A message holds values of any type, whatever its class says.
        async def start(client_id: Any, message: Any) -> None:
            button = gui._gui_input_handle_from_uuid.get(str(message.source_component_uuid))
            names = (message.transfer_uuid, message.filename, message.mime_type)
            if not isinstance(button, viser.GuiUploadButtonHandle) or not all(
                isinstance(name, str) and len(name) <= _LONGEST_NAME for name in names
            ):
                return
            gui._drop_uploads_from_client(client_id)
            size, parts = message.size_bytes, message.part_count
            right = isinstance(size, int) and parts == math.ceil(size / UPLOAD_PART)
            if not right or not 0 <= size <= MAX_UPLOAD or message.mime_type == _TOO_LARGE:
                reason = f"too large; expected at most {MAX_UPLOAD >> 20} MB"
                await _refuse_upload(client, message, reason)
                return
            self._uploads.begin(client.client_id, peer)
            gui._handle_file_transfer_start(client_id, message)
            self._count(client, 0)

        def part(client_id: Any, message: Any) -> None:
            if not isinstance(message.transfer_uuid, str) or not isinstance(message.content, bytes):
                return
            state = gui._current_file_upload_states.get(message.transfer_uuid)
            index = message.part_index
            if state is None or not isinstance(index, int) or index in state["parts"] or index < 0:
                return
            left = state["total_bytes"] - index * UPLOAD_PART
            if len(message.content) == min(left, UPLOAD_PART):
                gui._handle_file_transfer_part(client_id, message)
                self._count(client, len(message.content))
                if message.transfer_uuid not in gui._current_file_upload_states:
                    _forget_success(client, message.transfer_uuid)

        for kind, accept in (
            (messages.FileTransferStartUpload, start),
            (messages.FileTransferPart, part),
        ):
            connection.unregister_handler(kind)
            connection.register_handler(kind, accept)
        asyncio.get_running_loop().call_later(_IDLE_PERIOD, self._drop_idle, client)

    def _count(self, client: viser.ClientHandle, size: int) -> None:
        """Count bytes of a tab's file, and drop files for which there is no room."""
        if not client.gui._current_file_upload_states:  # complete
            self._uploads.end(client.client_id)
        self._drop(self._uploads.part(client.client_id, size))

    def _drop_idle(self, client: viser.ClientHandle) -> None:
        if client.client_id in self._connected_clients:
            self._drop(self._uploads.idle())
            loop = asyncio.get_running_loop()
            loop.call_later(_IDLE_PERIOD, self._drop_idle, client)

    def _drop(self, tabs: list[int]) -> None:
        for client in filter(None, map(self._connected_clients.get, tabs)):
            gui = client.gui
            names = [state["filename"] for state in gui._current_file_upload_states.values()]
            gui._drop_uploads_from_client(client.client_id)  # type: ignore[arg-type]
            for name in names:
                reason = f"{name}: it came too slowly, or others sent too much; try again"
                client.add_notification("Not opened", reason, color="orange")

    async def _forget(self, client: viser.ClientHandle) -> None:
        self._uploads.end(client.client_id)


def size_of(value: Any, most: float) -> float:
    """Bytes that a message holds, about; counting ends beyond `most`."""
    size, rest = 0.0, [value]
    while rest and size <= most:
        value = rest.pop()
        if isinstance(value, (str, bytes, bytearray)):
            size += len(value)
        elif isinstance(value, np.ndarray):
            size += value.nbytes
        elif isinstance(value, Mapping):
            rest += value.keys()
            rest += value.values()
            size += _OBJECT
        elif isinstance(value, (list, tuple)):
            rest += value
            size += _OBJECT
        elif dataclasses.is_dataclass(value):
            rest += vars(value).values()
            size += _OBJECT
        else:
            size += 8
    return size


def take_upload(button: viser.GuiUploadButtonHandle) -> viser.UploadedFile | None:
    """The file that came last, once: viser would keep it as long as the tab is open."""
    file = button.value
    button._impl.value = _NO_FILE
    return None if file is _NO_FILE or not isinstance(file, viser.UploadedFile) else file


def _forget_success(client: viser.ClientHandle, transfer: str) -> None:
    """Take back the page's word that a file was uploaded: what it holds is said elsewhere."""
    gone = messages.RemoveNotificationMessage(f"upload-{transfer}")
    loop = asyncio.get_running_loop()
    loop.call_later(_SETTLING, client._websock_connection.queue_message, gone)


async def _refuse_upload(client: viser.ClientHandle, message: Any, why: str) -> None:
    """Show why, and end the page's progress bar: it goes on sending, and nothing is kept."""
    size = max(message.size_bytes, 0) if isinstance(message.size_bytes, int) else 0
    client._websock_connection.queue_message(
        messages.FileTransferPartAck(
            source_component_uuid=message.source_component_uuid,
            transfer_uuid=message.transfer_uuid,
            transferred_bytes=size,
            total_bytes=size,
        )
    )
    client.add_notification("Not opened", f"{message.filename}: {why}", color="orange")
    await asyncio.sleep(_SETTLING)
    client._websock_connection.queue_message(
        messages.RemoveNotificationMessage(f"upload-{message.transfer_uuid}")
    )


def _is_bad_message(error: Exception) -> bool:
    """True if a connection ended because something arrived that is no message of viser's."""
    frames = traceback.extract_tb(error.__traceback__)
    return any(frame.name == "_message_consumer" for frame in frames)


@contextlib.contextmanager
def silent() -> Iterator[None]:
    """viser prints boxes whatever `verbose` says; the terminal gets our one line instead."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield


def run_javascript(client: viser.ClientHandle, source: str) -> None:
    """Have a tab run a script after all that was sent to it; it holds no text of a visitor."""
    client._websock_connection.queue_message(messages.RunJavascriptMessage(source))


def uuid_of(handle: Any) -> str:
    """The name by which a page knows a control."""
    return str(handle._impl.uuid)


@contextlib.contextmanager
def _behind(door: Door) -> Iterator[None]:
    """Put a viser server that is made behind a door; its own answers are never wanted."""
    serve = websockets.asyncio.server.serve

    def serve_behind_door(handler: Any, *args: Any, **options: Any) -> Any:
        options |= door.options(handler)
        return serve(options.pop("handler"), *args, **options)

    websockets.asyncio.server.serve = serve_behind_door  # type: ignore[assignment,misc]
    try:
        yield
    finally:
        websockets.asyncio.server.serve = serve  # type: ignore[misc]
