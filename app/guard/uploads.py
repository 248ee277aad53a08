"""Files that tabs send: as large as they may be, one at a time, and to upload buttons alone.

viser would keep the parts of any number of files of any size, sent to any control.
"""

from __future__ import annotations

import asyncio
import math
from typing import Any

import viser
import viser._messages as messages

from app.guard.limits import MAX_UPLOAD, UPLOAD_PART

_TOO_LARGE = "application/x-too-large"  # the type by which the page says so, of nothing
_LONGEST_NAME = 255  # characters of an uploaded file's name, or of an identifier
_SETTLING = 0.3  # s until a page has drawn what an upload's end makes it draw

UPLOAD_MESSAGES = (messages.FileTransferStartUpload, messages.FileTransferPart)


class Uploads:
    """The files that all tabs are sending; on the server's event loop alone."""

    def __init__(self, limit: int) -> None:
        """Allow so many bytes at a time, of all tabs together."""
        self._limit = limit
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
            elif size + sum(self._announced.values()) > self._limit:
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

        for kind in UPLOAD_MESSAGES:
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
