"""What a tab may send that is no click: files and messages of any size and shape."""

import contextlib
import gc
import logging
import random
import re
import time
from pathlib import Path

import msgspec
import numpy as np
import pytest
import viser
import viser._messages as messages

from app.guard.limits import MAX_UPLOAD, UPLOAD_PART, Limits
from app.guard.uploads import Uploads
from app.viser_private import size_of
from tests.app.design_page import design_page
from tests.app.raw_tab import CAMERA, RawTab


@pytest.fixture(scope="module")
def page():
    with design_page() as running:
        yield running


@pytest.fixture
def tab(page):
    page.guard.refusals.forget()
    while not page.tabs.empty():  # of a test that failed
        page.tabs.get()
    with RawTab(page.port) as opened:
        opened.client, _ = page.tabs.get(timeout=20)
        opened.control("Save design")
        yield opened


def kept(client):
    """Bytes that the server keeps of unfinished uploads, and how many there are."""
    states = client.gui._current_file_upload_states.values()
    return sum(len(part) for state in states for part in state["parts"].values()), len(states)


@pytest.mark.parametrize("size", [0, 1, UPLOAD_PART, UPLOAD_PART + 1, MAX_UPLOAD])
def test_a_file_comes_through_whole_and_is_not_kept(page, tab, size):
    content = random.Random(0).randbytes(size)
    tab.upload("Open", "one.bin", content)
    kind, name, got = page.next()
    assert (kind, name, got == content) == ("upload", "one.bin", True)
    tab.wait(lambda: tab.acknowledged.get("transfer") == (size, size), "the acknowledgement")
    (button,) = (
        handle
        for handle in tab.client.gui._gui_input_handle_from_uuid.values()
        if isinstance(handle, viser.GuiUploadButtonHandle)
    )
    assert button.value.content == b""
    assert kept(tab.client) == (0, 0)


def test_a_larger_one_is_refused_at_its_start(page, tab):
    size = MAX_UPLOAD + 1
    tab.upload("Open", "big.bin", bytes(size))
    tab.press("Save design")
    assert page.next() == ("save",)
    expected = ("Not opened", "big.bin: too large; expected at most 20 MB")
    tab.wait(lambda: expected in tab.notifications, "the refusal")
    tab.wait(lambda: "RemoveNotificationMessage" in tab.received, "the progress bar's end")
    assert tab.acknowledged["transfer"] == (size, size)  # ends the progress bar
    assert kept(tab.client) == (0, 0)


def begin(tab, size, transfer="begun"):
    """Announce a file and send none of it."""
    source = tab.control("Open")["uuid"]
    start = {"source_component_uuid": source, "transfer_uuid": transfer, "filename": "a.bin"}
    start |= {"mime_type": "", "part_count": -(-size // UPLOAD_PART), "size_bytes": size}
    tab.send({"type": "FileTransferStartUpload", **start})


def test_files_that_are_not_sent_keep_nobody_from_opening(page, tab, monkeypatch):
    others = []
    with contextlib.ExitStack() as stack:
        for _ in range(3):  # one after the other: viser reports connections in any order
            other = stack.enter_context(RawTab(page.port))
            other.client, _ = page.tabs.get(timeout=20)
            begin(other, MAX_UPLOAD)
            other.wait(lambda o=other: kept(o.client) == (0, 1), "its beginning")
            others.append(other)
        tab.upload("Open", "one.bin", b"one")
        assert page.next() == ("upload", "one.bin", b"one")
        monkeypatch.setattr(page.server._uploads, "_now", lambda: time.monotonic() + 20)
        slow = "a.bin: it came too slowly, or others sent too much; try again"
        for other in others:
            other.wait(lambda o=other: ("Not opened", slow) in o.notifications, "its end")
            assert kept(other.client) == (0, 0)


def test_room_is_made_by_the_peer_with_most_and_the_file_that_waits_longest():
    clock = [0.0]
    uploads = Uploads(Limits(upload_bytes=100, upload_idle_s=10.0), lambda: clock[0])
    for tab, peer, size in ((1, "a", 40), (2, "a", 40), (3, "b", 20)):
        uploads.begin(tab, peer)
        assert uploads.part(tab, size) == []
        clock[0] += 1.0
    assert uploads.part(3, 20) == [1]
    assert uploads.part(1, 1000) == []  # it is forgotten
    clock[0] = 11.5
    assert uploads.idle() == [2]
    assert uploads.part(3, 60) == []
    assert uploads.part(3, 10) == [3]


@pytest.mark.parametrize("index", [1, -1, 1.0])
def test_a_part_that_does_not_belong_is_dropped(page, tab, index):
    begin(tab, 4)
    part = {"source_component_uuid": tab.control("Open")["uuid"], "transfer_uuid": "begun"}
    for content in (b"more", b"m"):
        tab.send({"type": "FileTransferPart", "part_index": index, "content": content, **part})
    tab.send({"type": "FileTransferPart", "part_index": 0, "content": b"fine", **part})
    assert page.next() == ("upload", "a.bin", b"fine")


@pytest.mark.parametrize(
    "declared",
    [
        {"size_bytes": 10},  # more comes than was declared
        {"size_bytes": 1 << 40},
        {"part_count": -1},
        {"source_component_uuid": ["nosuch"]},
        {"transfer_uuid": ["unhashable"]},
        {"transfer_uuid": "another"},
        {"filename": "x" * 256},
        {"filename": 7},
        {"mime_type": None},
    ],
)
def test_a_file_that_is_not_as_declared_is_dropped(page, tab, declared):
    tab.upload("Open", "a.json", bytes(100), **declared)
    tab.upload("Open", "b.json", b"fine", transfer="next")
    assert page.next() == ("upload", "b.json", b"fine")
    assert kept(tab.client) == (0, 0)


def test_a_file_goes_to_upload_buttons_only(page, tab):
    tab.upload("Twist [deg]", "a.json", b"not a number")
    tab.press("Save design")
    assert page.next() == ("save",)


def test_unfinished_uploads_do_not_pile_up(page, tab):
    for number in range(100):
        begin(tab, 5, str(number))
    tab.press("Save design")
    assert page.next() == ("save",)
    assert kept(tab.client) == (0, 1)


def test_parts_without_a_start_are_dropped(page, tab):
    part = {"source_component_uuid": None, "transfer_uuid": "nosuch", "part_index": 0}
    for content in (b"", bytes(UPLOAD_PART), "text", 7, None):
        tab.send({"type": "FileTransferPart", "content": content, **part})
    tab.press("Save design")
    assert page.next() == ("save",)
    assert kept(tab.client) == (0, 0)


GARBAGE = [
    b"",
    random.Random(1).randbytes(1000),
    b"\x91" * 100_000,
    msgspec.msgpack.encode({"type": ["GuiUpdateMessage"]}),
    msgspec.msgpack.encode({"type": "GuiUpdateMessage", "nosuch": 1}),
    msgspec.msgpack.encode(CAMERA | {"wxyz": 7}),
    "text",
]


@pytest.mark.parametrize("garbage", GARBAGE, ids=lambda garbage: repr(garbage[:20]))
def test_garbage_closes_its_connection_and_no_other(page, tab, garbage, caplog):
    with caplog.at_level(logging.WARNING), RawTab(page.port) as bad:
        page.tabs.get(timeout=20)
        bad._connection.send(garbage)
        assert bad.closed.wait(10)
    assert bad._connection.protocol.close_rcvd.code == 1007
    (record,) = (r for r in caplog.records if r.name == "app.guard.refusals")
    assert "a tab sent what cannot be read (" in record.getMessage()
    assert not any(r.exc_info for r in caplog.records)
    tab.set("Twist [deg]", 7)
    assert page.next() == ("slider", 7)
    with RawTab(page.port) as fresh:
        page.tabs.get(timeout=20)
        fresh.press("Save design")
        assert page.next() == ("save",)


@pytest.mark.parametrize(
    ("label", "updates"),
    [
        ("Twist [deg]", {"value": "x" * 1000}),
        ("Twist [deg]", {"value": float("nan")}),
        ("Twist [deg]", {"value": None}),
        ("Open", {"value": [1]}),
        ("Format", [1, 2]),
        ("Save design", None),
    ],
)
def test_a_message_that_makes_no_sense_is_ignored_in_one_line(page, tab, label, updates, caplog):
    uuid = tab.control(label)["uuid"]
    with caplog.at_level(logging.WARNING):
        tab.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": updates})
        tab.press("Save design")
        assert page.next() == ("save",)
        gc.collect()  # asyncio tells of a failed task when it is forgotten
    expected = (
        r"refused \S+: a tab sent a GuiUpdateMessage that makes no sense \(\w+Error\); ignored"
    )
    (record,) = caplog.records
    assert re.fullmatch(expected, record.getMessage())
    assert record.exc_info is None


@pytest.mark.filterwarnings("ignore:.*does not match annotation")  # repeats all of it
def test_of_a_control_only_a_small_value_can_be_set(page, tab, caplog):
    uuid = tab.control("Twist [deg]")["uuid"]
    (button,) = (
        handle
        for handle in tab.client.gui._gui_input_handle_from_uuid.values()
        if handle._impl.uuid == uuid
    )
    before = dict(vars(button._impl))
    for updates in (
        {"label": "x" * 900_000},
        {"props": "x" * 900_000},
        {"nosuch": 1},
        {"value": 8, "update_cb": [], "label": "y"},
        {"value": "7" * 5000},
        {"value": [7] * 5000},
    ):
        tab.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": updates})
    tab.send(CAMERA | {"wxyz": "x" * 900_000})
    tab.press("Save design")
    assert [page.next(), page.next()] == [("slider", 8), ("save",)]
    changed = {name for name, value in vars(button._impl).items() if value is not before[name]}
    assert changed <= {"value", "update_timestamp"}
    assert not isinstance(tab.client.camera._state.wxyz, str)
    assert [record.getMessage() for record in caplog.records] == [
        "refused 127.0.0.1: a tab sent too much in a GuiUpdateMessage; ignored",
        "refused 127.0.0.1: a tab sent too much in a ViewerCameraMessage; ignored",
    ]


@pytest.mark.parametrize(
    ("value", "least"),
    [
        (None, 0),
        ("abc", 3),
        (np.zeros((10, 3), np.float32), 120),
        (("ab", ["c"], {"x": b"d"}), 5),
        (messages.RunJavascriptMessage("x" * 1000), 1000),
    ],
)
def test_bytes_of_a_message(value, least):
    assert least <= size_of(value, 1e9) < least + 500
    assert size_of([value] * 1000, 10) < 2000  # counting ends soon


def test_a_defect_of_the_page_is_told_in_full(page, tab, caplog):
    button = tab.client.gui.add_button("Defective")

    @button.on_click
    async def _(event):
        tab.client.gui.add_slider("of nothing", min=1, max=0, step=1, initial_value=3)

    with caplog.at_level(logging.WARNING):
        tab.press("Defective")
        tab.press("Save design")
        assert page.next() == ("save",)
        gc.collect()
    assert any(record.exc_info for record in caplog.records)


def test_the_page_sends_files_in_parts_of_the_size_that_is_let_through():
    client = Path(viser.__file__).parent / "client/src/components/UploadButton.tsx"
    assert "const chunkSize = 512 * 1024;" in client.read_text()
    assert UPLOAD_PART == 512 * 1024
    assert MAX_UPLOAD % UPLOAD_PART == 0
