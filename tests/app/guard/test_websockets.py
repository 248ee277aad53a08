"""Counting connections, and those that send too much, too fast, too slowly or not at all."""

import contextlib
import logging
import random
import socket
import time

import msgspec
import pytest
import viser
from websockets.exceptions import ConnectionClosed
from websockets.frames import Frame, Opcode
from websockets.sync.client import connect

from app.guard.limits import MAX_UPLOAD, Limits, Rate
from app.guard.policy import Guard
from app.guard.token import Access
from app.viser_private import run_javascript
from tests.app.design_page import design_page
from tests.app.raw_http import UPGRADE, asked, sent
from tests.app.raw_tab import CAMERA, RawTab
from tests.app.waits import wait_until

PROTOCOL = f"viser-v{viser.__version__}"
SMALL = Limits(
    tabs=6,
    tabs_per_peer=5,
    first_message_s=2.5,
    pending=6,
    open_s=1.0,
    close_s=0.5,
    messages=Rate(100, 100),
    flood_s=1.0,
    controls=Rate(1, 20),
    fragments=50,
    backlog_bytes=8 << 20,
    stalled_s=2.0,
)


@pytest.fixture(scope="module")
def page():
    proxies = ("127.0.0.1",)  # of those requests that say who they are of
    guard = Guard(Access(None), (), loopback=True, proxies=proxies, limits=SMALL)
    with design_page(guard) as running:
        yield running


@pytest.fixture
def door(page):
    door = page.server.door
    gone = lambda: not door.pending | door.tabs and not page.server.get_clients()  # noqa: E731
    wait_until(gone, "an empty server")
    page.guard.refusals.forget()
    return door


def opened(page, **options):
    options = {"subprotocols": [PROTOCOL], "max_size": None} | options
    return connect(f"ws://127.0.0.1:{page.port}", **options)


def noted(caplog):
    """Lines of the server's log."""
    return [record.getMessage() for record in caplog.records if record.name != "websockets.client"]


def closing(socket):
    """How the server ended a connection."""
    try:
        while True:
            socket.recv(timeout=20)
    except ConnectionClosed as closed:
        return closed.rcvd and closed.rcvd.code


def assert_answered(page, tab):
    """Whatever else is sent, what this tab presses is heard."""
    tab.press("Save design")
    while page.next() != ("save",):
        pass


# ---- counting


def test_only_open_websockets_are_tabs(page, door):
    address = ("127.0.0.1", page.port)
    with socket.create_connection(address), opened(page), opened(page):
        wait_until(lambda: len(door.pending) == 1, "the silent one")
        assert len(door.tabs) == 2
        assert asked(page.port).status == 200
        assert len(door.tabs) == 2
    wait_until(lambda: not door.pending | door.tabs, "all gone")


def test_failed_handshakes_leave_nothing_behind(page, door):
    for i in range(40):
        match i % 4:
            case 0:
                asked(page.port, headers=UPGRADE | {"Sec-WebSocket-Key": "bad"})
            case 1:
                asked(page.port, headers=UPGRADE | {"Origin": "http://evil.example"})
            case 2:
                sent(page.port, b"GET / HTTP/1.1\r\n\r\n")
            case 3:  # gone in the middle of it
                with socket.create_connection(("127.0.0.1", page.port)) as plain:
                    plain.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\n")
    wait_until(lambda: not door.pending | door.tabs, "all gone")


def test_behind_a_proxy_each_visitor_has_limits_of_his_own(page, door):
    visitors = [{"X-Forwarded-For": f"203.0.113.{number}"} for number in range(2)]
    camera = msgspec.msgpack.encode(CAMERA)
    with contextlib.ExitStack() as stack:
        for _ in range(SMALL.tabs_per_peer):
            stack.enter_context(opened(page, additional_headers=visitors[0])).send(camera)
        wait_until(lambda: not any(tab.silent for tab in door.tabs), "their messages")
        assert asked(page.port, headers=UPGRADE | visitors[0]).status == 503
        stack.enter_context(opened(page, additional_headers=visitors[1])).send(camera)
        assert {tab.peer for tab in door.tabs} == {"203.0.113.0", "203.0.113.1"}


def test_a_wrong_token_beyond_the_rate_is_answered_after_a_while():
    limits = Limits(wrong_tokens=Rate(0.01, 1.0), wrong_token_s=0.5)
    with design_page(Guard(Access("t" * 16), (), loopback=True, limits=limits)) as slow:
        asked(slow.port, "/?token=wrong")
        began = time.monotonic()
        assert asked(slow.port, "/?token=wrong").status == 401
        assert time.monotonic() - began >= 0.5
        assert asked(slow.port, f"/?token={'t' * 16}").status == 303


def test_the_tab_beyond_the_limit_is_refused_and_one_that_goes_makes_room(page, door):
    camera = msgspec.msgpack.encode(CAMERA)
    with contextlib.ExitStack() as stack:
        tabs = [stack.enter_context(opened(page)) for _ in range(SMALL.tabs_per_peer)]
        for tab in tabs:
            tab.send(camera)
        wait_until(lambda: not any(tab.silent for tab in door.tabs), "their first messages")
        answer = asked(page.port, headers=UPGRADE)
        assert (answer.status, answer.headers["Retry-After"]) == (503, "1")
        assert b"too many open tabs (of one address at most 5)" in answer.body
        assert asked(page.port).status == 200
        tabs[0].close()
        wait_until(lambda: len(door.tabs) < SMALL.tabs_per_peer, "its end")
        stack.enter_context(opened(page))


def test_silent_tabs_make_room_for_others_and_are_closed(page, door, caplog):
    with contextlib.ExitStack() as stack:
        silent = [stack.enter_context(opened(page)) for _ in range(3 * SMALL.tabs)]
        honest = stack.enter_context(RawTab(page.port))
        honest.control("Save design")
        assert len(door.tabs) <= SMALL.tabs_per_peer
        closing(silent[0])
        wait_until(lambda: len(door.tabs) == 1, "the end of all that send nothing")
        assert_answered(page, honest)
    assert "refused 127.0.0.1: a tab sent nothing for 2.5 s; closed" in noted(caplog)


def test_silent_connections_make_room_for_others_and_are_cut(page, door, caplog):
    with contextlib.ExitStack() as stack:
        address = ("127.0.0.1", page.port)
        waiting = [
            stack.enter_context(socket.create_connection(address)) for _ in range(4 * SMALL.pending)
        ]
        assert asked(page.port).status == 200
        for plain in waiting:
            plain.settimeout(20)
            with contextlib.suppress(ConnectionResetError):
                assert plain.recv(100) == b""
    assert "refused 127.0.0.1: too many connections at a time; closed" in noted(caplog)
    wait_until(lambda: not door.pending, "all gone")


def test_a_page_that_is_not_fetched_is_given_up(page, door):
    with socket.socket() as plain:
        plain.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        plain.connect(("127.0.0.1", page.port))
        plain.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        wait_until(lambda: len(door.pending) == 1, "the request")
        wait_until(lambda: not door.pending, "its end")


# ---- what a tab sends


def test_a_tab_that_floods_is_slowed_down_and_closed(page, door, caplog):
    with RawTab(page.port) as honest, opened(page) as flooding:
        honest.control("Save design")
        # The camera's alone: nothing answers.
        message = msgspec.msgpack.encode(CAMERA)
        with contextlib.suppress(ConnectionClosed):
            while True:
                flooding.send(message)
        assert closing(flooding) in (1008, None)
        assert_answered(page, honest)
        wait_until(lambda: len(page.server.get_clients()) == 1, "its end")
    assert noted(caplog) == ["refused 127.0.0.1: too many messages; closed"]


def test_faster_messages_wait_in_order_and_none_is_lost(page, door):
    values = list(range(1, 171))
    with RawTab(page.port) as tab:
        tab.control("Twist [deg]")
        begun = time.monotonic()
        for value in values:
            tab.set("Twist [deg]", value)
        assert [page.next() for _ in values] == [("slider", value) for value in values]
        assert time.monotonic() - begun > 0.5  # 100 at once, and 100 a second
        assert not tab.closed.is_set()


def test_dragging_and_a_large_file_are_not_slowed_down():
    limits = Limits()
    # 20 changes of controls and 50 of the camera a second, in the long run.
    assert limits.messages.per_second >= 2 * 70
    assert limits.messages.burst >= MAX_UPLOAD / limits.message_bytes


def test_pings_are_limited(page, door, caplog):
    with opened(page) as tab:
        with contextlib.suppress(ConnectionClosed):
            for _ in range(100):
                tab.ping()
        closing(tab)
    assert noted(caplog) == ["refused 127.0.0.1: too many pings; closed"]


def test_a_message_of_endless_fragments_is_cut(page, door, caplog):
    with opened(page) as tab:
        frames = [Frame(Opcode.BINARY, b"", fin=False)]
        frames += [Frame(Opcode.CONT, b"", fin=False)] * 100
        tab.socket.sendall(b"".join(frame.serialize(mask=True) for frame in frames))
        closing(tab)
    assert noted(caplog) == ["refused 127.0.0.1: message in too many fragments; closed"]


MALFORMED = (
    b"\xff\xff" + bytes(20),  # reserved bits
    b"\x82\x05hello",  # not masked
    b"\x83\x80\x00\x00\x00\x00",  # no such kind
    b"\x89\xfe\x01\x00" + bytes(300),  # a long ping
    b"\x80\x80\x00\x00\x00\x00",  # the rest of nothing
    b"\x82\xff" + b"\xff" * 12,  # as long as can be
    b"\x81\x82\x00\x00\x00\x00\xff\xfe",  # no UTF-8
)


def test_malformed_frames_close_their_connection_and_no_other(page, door, caplog):
    with RawTab(page.port) as honest:
        honest.control("Save design")
        for frame in MALFORMED:
            with opened(page) as bad:
                bad.socket.sendall(frame)
                closing(bad)
        assert_answered(page, honest)
    assert all(not record.exc_info for record in caplog.records)


# ---- what a tab does not read


def deaf_tab(page, stack):
    """A tab that reads nothing, as the server sees it."""
    known = set(page.server.get_clients())
    plain = stack.enter_context(socket.socket())
    plain.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    plain.connect(("127.0.0.1", page.port))
    wanted = UPGRADE | {"Host": "127.0.0.1", "Sec-WebSocket-Protocol": PROTOCOL}
    lines = ["GET / HTTP/1.1", *(f"{name}: {value}" for name, value in wanted.items()), "", ""]
    plain.sendall("\r\n".join(lines).encode())
    assert plain.recv(100).startswith(b"HTTP/1.1 101")
    camera = Frame(Opcode.BINARY, msgspec.msgpack.encode(CAMERA))
    plain.sendall(camera.serialize(mask=True))
    wait_until(lambda: set(page.server.get_clients()) - known, "it")
    (number,) = set(page.server.get_clients()) - known
    client = page.server.get_clients()[number]
    client.plain = plain
    return client


def noise(size):
    """Text that cannot be compressed to much less."""
    return random.Random(0).randbytes(size // 2).hex()


def test_a_tab_that_reads_nothing_is_closed(page, door, caplog):
    with contextlib.ExitStack() as stack:
        client = deaf_tab(page, stack)
        for _ in range(4):  # compressed to half
            run_javascript(client, noise(1_000_000))
        wait_until(lambda: not door.tabs, "its end")
    assert noted(caplog) == ["refused 127.0.0.1: a tab took nothing for 2 s; closed"]


def test_what_waits_for_a_tab_is_bounded(page, door, caplog):
    with contextlib.ExitStack() as stack:
        client = deaf_tab(page, stack)
        run_javascript(client, noise(4_000_000))  # is on its way
        queue = client._websock_connection.get_message_buffer()
        wait_until(lambda: not queue.message_from_id, "its beginning")
        for _ in range(12):
            run_javascript(client, noise(1_000_000))
        wait_until(lambda: not door.tabs, "its end")
        wait_until(lambda: queue.done, "no more of it")
    assert noted(caplog) == ["refused 127.0.0.1: too much waits for a tab; closed"]


def test_a_tab_that_reads_slowly_stays(page, door, caplog):
    with contextlib.ExitStack() as stack:
        client = deaf_tab(page, stack)
        plain = client.plain
        run_javascript(client, noise(10_000_000))
        begun = time.monotonic()
        while time.monotonic() - begun < 2 * SMALL.stalled_s:
            plain.recv(20_000)
            time.sleep(0.01)
        assert client._websock_connection.get_message_buffer().done is False
        assert len(door.tabs) == 1
    assert noted(caplog) == []


# ---- the log


def test_ten_thousand_of_a_kind_are_one_line(page, door, caplog):
    with caplog.at_level(logging.INFO, "app"), RawTab(page.port) as tab:
        uuid = tab.control("Twist [deg]")["uuid"]
        for _ in range(150):
            tab.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": "x"}})
            asked(page.port, host="evil.example")
            sent(page.port, b"BREW / HTTP/1.1\r\n\r\n")
        assert_answered(page, tab)
    assert len(noted(caplog)) == len(set(noted(caplog))) == 3
    assert all(not record.exc_info for record in caplog.records)


def test_a_watch_that_fails_is_logged_and_ends_its_tab(page, door, caplog, monkeypatch):
    monkeypatch.setattr(door, "_waiting", lambda _: 1 / 0)
    with opened(page) as tab:
        assert closing(tab) is None
    assert "a connection ran into a defect" in noted(caplog)
