"""A tab without a browser: speaks viser's protocol and keeps what a browser would show."""

import re
import threading
import time
from collections import Counter
from html import unescape
from types import MappingProxyType

import msgspec
import numpy as np
import viser
import zstandard
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from app.tab.planning.requests import ANSWERS
from tests.app.page_script import PageScript

PLANNED = "Draft", "Feasible"  # words on a plan, certified or not
CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (2.0, 2.0, 1.0),
    "fov": 1.0,
    "near": 0.1,
    "far": 100.0,
    "image_height": 600,
    "image_width": 800,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}


class RawTab:
    def __init__(self, port, page=MappingProxyType({}), **options):
        """A tab; `page` is what its scripts answer when they are greeted, None if none run."""
        self._connection = connect(
            f"ws://127.0.0.1:{port}",
            subprotocols=[f"viser-v{viser.__version__}"],
            max_size=None,
            **options,
        )
        self.controls = {}  # uuid -> message
        self.nodes = {}  # name -> {"position", "wxyz", **props}
        self.camera = {}  # "position", "look_at"
        self.notifications = []
        self.downloads = []  # (file name, content), complete ones
        self.scripts = []  # JavaScript it was told to run
        self.page = PageScript(self, page)
        self.acknowledged = {}  # transfer -> (bytes received, bytes in all) of uploads
        self._transfers = {}  # transfer -> [file name, size, content so far]
        self.received = Counter()  # message type -> count
        self.received_bytes = 0
        self.closed = threading.Event()
        self._changed = threading.Condition()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self.send(CAMERA)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._connection.close()
        self._reader.join()

    # ---- doing

    def send(self, message):
        self._connection.send(msgspec.msgpack.encode(message))

    def set(self, label, value, prop="value"):
        updates = {prop: value}
        uuid = self.control(label)["uuid"]
        self.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": updates})

    def press(self, label):
        self.set(label, True)

    def upload(self, label, name, content, transfer="transfer", **declared):
        """Send a file as viser's page does, except for what is declared differently."""
        size = 512 * 1024
        parts = [content[i : i + size] for i in range(0, len(content), size)]
        source = self.control(label)["uuid"]
        transfer = {"source_component_uuid": source, "transfer_uuid": transfer}
        start = {"filename": name, "mime_type": "", "part_count": len(parts)}
        start |= {"size_bytes": len(content)} | transfer | declared
        self.send({"type": "FileTransferStartUpload", **start})
        for index, part in enumerate(parts):
            part = {"part_index": index, "content": part} | transfer
            self.send({"type": "FileTransferPart", **part})

    # ---- seeing

    def control(self, label):
        self.wait(lambda: self._find(label) is not None, f"control {label!r}")
        return self._find(label)

    def value(self, label):
        return self.control(label)["value"]

    def text(self):
        """All HTML of the panel as text."""
        with self._changed:
            html = " ".join(
                m["props"]["content"]
                for m in self.controls.values()
                if m["type"] == "GuiHtmlMessage"
            )
        return unescape(re.sub(r"<[^>]*>", "\n", html))

    def status(self):
        return " ".join(unescape(re.sub(r"<[^>]*>", "", self._status_html())).split())

    def _status_html(self):
        with self._changed:
            for message in self.controls.values():
                content = message["props"].get("content", "")
                if 'role="status"' in content:
                    return content
        return ""

    def wait(self, condition, what, timeout=60.0):
        end = time.monotonic() + timeout
        with self._changed:
            while not condition():
                left = end - time.monotonic()
                assert left > 0, f"waited in vain for {what}; status: {self.status()!r}"
                self._changed.wait(min(left, 0.2))

    def wait_for_status(self, word, timeout=60.0):
        """A word, or one of several; an answer that is still being refined does not count."""
        words = (word,) if isinstance(word, str) else word

        def settled():
            busy = 'aria-busy="true"' in self._status_html()
            return self.status().startswith(words) and not (busy and {*words} & {*ANSWERS})

        self.wait(settled, f"status {word}", timeout)
        return self.status()

    # ---- inside

    def _find(self, label):
        for message in self.controls.values():
            if message["props"].get("label") == label and message["type"] != "GuiFolderMessage":
                return message
        return None

    def _read(self):
        try:
            for packet in self._connection:
                size, compressed = (int.from_bytes(packet[i : i + 8], "little") for i in (0, 8))
                inner = zstandard.ZstdDecompressor().decompress(
                    packet[16 : 16 + compressed], max_output_size=size
                )
                content = msgspec.msgpack.decode(inner)
                buffers = _buffers(packet, 16 + compressed, content["binaryBufferLengths"])
                with self._changed:
                    self.received_bytes += len(packet)
                    for message in _with_arrays(content["messages"], buffers):
                        self.received[message["type"]] += 1
                        self._take(message)
                    self._changed.notify_all()
        except ConnectionClosed:
            pass
        finally:
            self.closed.set()

    def _take(self, message):
        kind = message["type"]
        if "uuid" in message and "props" in message and kind.startswith("Gui"):
            self.controls[message["uuid"]] = message
        elif kind == "GuiUpdateMessage":
            control = self.controls[message["uuid"]]
            for prop, value in message["updates"].items():
                (control if prop == "value" else control["props"])[prop] = value
        elif kind == "GuiRemoveMessage":
            self.controls.pop(message["uuid"], None)
        elif kind == "SetCameraPositionMessage":
            self.camera["position"] = message["position"]
        elif kind == "SetCameraLookAtMessage":
            self.camera["look_at"] = message["look_at"]
        elif kind == "SetPositionMessage":
            self.nodes.setdefault(message["name"], {})["position"] = message["position"]
        elif kind == "SetOrientationMessage":
            self.nodes.setdefault(message["name"], {})["wxyz"] = message["wxyz"]
        elif kind == "SetSceneNodeVisibilityMessage":
            self.nodes.setdefault(message["name"], {})["visible"] = message["visible"]
        elif kind == "SceneNodeUpdateMessage":
            self.nodes[message["name"]] |= message["updates"]
        elif kind == "RemoveSceneNodeMessage":
            self.nodes.pop(message["name"], None)
        elif "name" in message and "props" in message:
            self.nodes.setdefault(message["name"], {}).update(message["props"])
        elif kind == "NotificationShowMessage":
            self.notifications.append((message["props"]["title"], message["props"]["body"]))
        elif kind == "RunJavascriptMessage":
            self.scripts.append(message["source"])
            self.page.take(message["source"])
        elif kind == "FileTransferPartAck":
            received = message["transferred_bytes"], message["total_bytes"]
            self.acknowledged[message["transfer_uuid"]] = received
        elif kind == "FileTransferStartDownload":
            name, size = message["filename"], message["size_bytes"]
            self._transfers[message["transfer_uuid"]] = [name, size, b""]
        elif kind == "FileTransferPart":
            transfer = self._transfers[message["transfer_uuid"]]
            transfer[2] += message["content"]
            if len(transfer[2]) == transfer[1]:
                self.downloads.append((transfer[0], transfer[2]))


def _buffers(packet, offset, lengths):
    """The raw arrays behind a message, each aligned to 8 bytes."""
    found = []
    for length in lengths:
        offset = -(-offset // 8) * 8
        found.append(packet[offset : offset + length])
        offset += length
    return found


def _with_arrays(value, buffers):
    """Placeholders replaced by flat arrays."""
    if isinstance(value, dict):
        if "__binary_index" in value:
            return np.frombuffer(buffers[value["__binary_index"]], value["dtype"])
        return {key: _with_arrays(item, buffers) for key, item in value.items()}
    if isinstance(value, list):
        return [_with_arrays(item, buffers) for item in value]
    return value


def planned(tab, session, condition, what):
    """The plan that a tab shows, when it is of such a jump."""
    tab.wait(lambda: session.state.plan is not None and condition(session.state.plan.jump), what)
    return session.state.plan


def choose(tab, session, robot):
    """Have a tab show another robot, and wait for its plan."""
    tab.set("Robot", robot)
    planned(tab, session, lambda jump: jump.robot == robot, f"a plan of {robot}")
    tab.wait_for_status("Feasible")


def pinned(tab):
    """Names of the ghosts of pins that are drawn; nodes of others are there for the next ones."""
    names = [
        name for name in list(tab.nodes) if name.startswith("/pinned/") and name.count("/") == 2
    ]
    return {name for name in names if tab.nodes[name].get("visible", True)}
