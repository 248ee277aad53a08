"""What the door promises over real sockets, and what it relies on in viser."""

import inspect
from collections import deque

import pytest
import viser
import websockets
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from app.guard.policy import Guard
from app.guard.token import Access
from app.page_template import page_html
from app.viser_private import DesignerServer, run_javascript
from tests.app.design_page import design_page
from tests.app.raw_http import UPGRADE, asked, sent
from tests.app.raw_tab import RawTab

PROTOCOL = [f"viser-v{viser.__version__}"]
TOKEN = "a-token-of_32-characters-exactly"


class Served:
    """Attributes: port; server; enter: headers by which a request comes in."""

    def __init__(self, page, enter):
        self.page, self.port, self.server, self.enter = page, page.port, page.server, enter


@pytest.fixture(scope="module")
def loopback():
    with design_page() as page:
        yield Served(page, {})


@pytest.fixture(scope="module")
def outside():
    guard = Guard(Access(TOKEN), (), loopback=False)
    with design_page(guard) as page:
        cookie = asked(page.port, f"/?token={TOKEN}").cookie
        yield Served(page, {"Cookie": cookie})


@pytest.fixture(params=["loopback", "outside"])
def served(request):
    return request.getfixturevalue(request.param)


def opened(served, **options):
    headers = options.pop("additional_headers", served.enter)
    options = {"subprotocols": PROTOCOL, "max_size": None} | options
    return connect(f"ws://127.0.0.1:{served.port}", additional_headers=headers, **options)


# ---- entering


def test_the_page_is_served_under_addresses_and_known_names(loopback):
    for host in ("127.0.0.1:{}", "localhost:{}", "[::1]:{}", "192.168.1.7:9000"):
        answer = asked(loopback.port, host=host.format(loopback.port))
        assert (answer.status, answer.body) == (200, page_html())


def test_another_host_is_refused(served):
    for host in ("evil.example", "", "[::1", "127.0.0.1@evil.example"):
        for headers in ({}, UPGRADE):
            answer = asked(served.port, headers={"Host": host, **served.enter, **headers})
            assert answer.status == 403, host
    assert b"--allow-host evil.example" in asked(served.port, host="evil.example").body
    twice = [("Host", f"127.0.0.1:{served.port}"), ("Host", "evil.example")]
    assert asked(served.port, headers=[*twice, *served.enter.items()]).status == 403


def test_a_page_of_another_site_cannot_connect(served):
    for origin in ("http://evil.example", "null", "http://127.0.0.1:1"):
        with pytest.raises(InvalidStatus) as refused:
            opened(served, origin=origin)
        assert refused.value.response.status_code == 403
        assert b"request from another site" in refused.value.response.body
        assert asked(served.port, headers={"Origin": origin, **served.enter}).status == 403


def test_the_own_page_connects(served):
    with opened(served, origin=f"http://127.0.0.1:{served.port}") as socket:
        assert socket.subprotocol == PROTOCOL[0]


def test_without_the_token_there_is_a_line_on_how_to_get_in(outside):
    for path in ("/", "/?token=wrong"):
        answer = asked(outside.port, path)
        assert answer.status == 401
        assert answer.body.count(b"\n") == 1
        assert b"?token=..." in answer.body
    for origin in (None, f"http://127.0.0.1:{outside.port}"):
        with pytest.raises(InvalidStatus) as refused:
            opened(outside, origin=origin, additional_headers={})
        assert refused.value.response.status_code == 401
        assert b"?token=..." in refused.value.response.body


def test_the_token_becomes_a_cookie(outside):
    answer = asked(outside.port, f"/?token={TOKEN}")
    assert (answer.status, answer.headers["Location"]) == (303, "/")
    assert answer.cookie.startswith(f"llsrbm-{outside.port}=")
    assert TOKEN not in str(answer.headers)
    assert asked(outside.port, headers={"Cookie": answer.cookie}).status == 200
    with RawTab(outside.port, additional_headers={"Cookie": answer.cookie}) as tab:
        tab.control("Save design")


def test_a_cookie_of_an_earlier_run_is_refused(outside):
    former = Access("former-" + TOKEN, outside.port)
    host = f"127.0.0.1:{outside.port}"
    headers = {"Cookie": former.cookie(host).partition(";")[0]}
    assert asked(outside.port, headers=headers).status == 401
    assert asked(outside.port, headers=headers | UPGRADE).status == 401
    assert (
        asked(outside.port, headers=outside.enter, host=f"localhost:{outside.port}").status == 401
    )


def test_nothing_but_the_page_is_there(served):
    for path in ("/assets/x.js", "/../../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/..\\x",
                 "http://evil.example/", "//", "/index.html/", "/favicon.ico"):  # fmt: skip
        answer = asked(served.port, path, headers=served.enter)
        assert answer.status == 404, path
        assert b"root:" not in answer.body


def test_every_answer_has_the_headers(served):
    host = f"127.0.0.1:{served.port}"
    answers = [
        asked(served.port, headers=served.enter),
        asked(served.port, headers=served.enter, host="evil.example"),
        asked(served.port, "/none", headers=served.enter),
        asked(served.port, method="POST"),
        asked(served.port, headers=served.enter | UPGRADE | {"Sec-WebSocket-Key": "x"}),
        asked(served.port, headers=served.enter | UPGRADE | {"Connection": "close"}),
    ]
    assert [answer.status for answer in answers] == [200, 403, 404, 405, 400, 426]
    for answer in answers:
        assert answer.headers["X-Content-Type-Options"] == "nosniff"
        assert answer.headers["X-Frame-Options"] == "DENY"
        assert "frame-ancestors 'none'" in answer.headers["Content-Security-Policy"]
        assert answer.headers["Referrer-Policy"] == "no-referrer"
        assert answer.headers["Cross-Origin-Opener-Policy"] == "same-origin"
        assert answer.headers["Cross-Origin-Resource-Policy"] == "same-origin"
        assert "camera=()" in answer.headers["Permissions-Policy"]
        assert answer.headers["Server"] is None
    assert f"ws://{host}" in answers[0].headers["Content-Security-Policy"]
    assert "evil" not in str(answers[1].headers)


# ---- methods


def test_head_is_get_without_the_page(served):
    lines = [f"Host: 127.0.0.1:{served.port}", *(f"{k}: {v}" for k, v in served.enter.items())]
    head = "\r\n".join(["HEAD / HTTP/1.1", *lines, "", ""]).encode()
    answer, _, body = sent(served.port, head).partition(b"\r\n\r\n")
    assert answer.startswith(b"HTTP/1.1 200 ")
    assert f"Content-Length: {len(page_html())}".encode() in answer
    assert body == b""


def test_other_methods_are_answered(served):
    for method in ("POST", "PUT", "OPTIONS", "TRACE"):
        answer = asked(served.port, method=method)
        assert (answer.status, answer.headers["Allow"]) == (405, "GET, HEAD")
    for nonsense in (b"\x16\x03\x01\x02\x00\x01", b"x" * 100, b"\x00" * 40, b" / HTTP/1.1\r\n\r\n"):
        assert sent(served.port, nonsense + b" " * 20) in (b"",) or nonsense.startswith(b"x")


def test_requests_that_are_none_end(served):
    for nonsense in (
        b"GET /\r\n\r\n",
        b"GET / HTTP/9\r\n\r\n",
        b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 200 + b"\r\n",
        b"GET /" + b"x" * 20_000 + b" HTTP/1.1\r\n\r\n",
        b"GET / HTTP/1.1\r\nContent-Length: 5\r\n\r\nhello",
        b"GET / HTTP/1.1\r\n\xff\xfe: x\r\n\r\n",
    ):
        assert not sent(served.port, nonsense).startswith(b"HTTP/1.1 200")


# ---- tabs


def test_a_large_message_closes_the_connection(served):
    with opened(served) as socket:
        socket.send(bytes(2 << 20))
        with pytest.raises(ConnectionClosed) as closed:
            deque(iter(lambda: socket.recv(timeout=10), None), maxlen=0)
    assert closed.value.rcvd.code == 1009


def test_a_page_of_another_version_hears_so_and_stdout_does_not(served, capfd):
    with opened(served, subprotocols=["viser-v0.0.1"]) as socket:
        with pytest.raises(ConnectionClosed) as closed:
            socket.recv(timeout=10)
        assert closed.value.rcvd.code == 1002
        assert closed.value.rcvd.reason.startswith("Version mismatch. Client: 0.0.1, Server: ")
    assert capfd.readouterr().out == ""


def test_no_client_can_open_a_tunnel(served, capfd, caplog):
    assert DesignerServer.request_share_url is not viser.ViserServer.request_share_url
    assert served.server.request_share_url() is None
    served.page.guard.refusals.forget()
    with RawTab(served.port, additional_headers=served.enter) as tab:
        tab.control("Save design")
        for _ in range(3):
            tab.send({"type": "ShareUrlRequest"})
            tab.send({"type": "ShareUrlDisconnect"})
        tab.press("Save design")
        assert served.page.next() == ("save",)
    assert not caplog.records
    assert capfd.readouterr().out == ""


def test_a_script_reaches_its_tab_and_no_other(designer):
    with RawTab(designer.port) as one:
        one.wait_for_status("Feasible")
        known = designer._server.get_clients().keys()
        with RawTab(designer.port) as other:
            other.wait_for_status("Feasible")
            (client,) = (
                client for key, client in designer._server.get_clients().items() if key not in known
            )
            run_javascript(client, "first()")
            run_javascript(client, "second()")
            client.add_notification("last", "")
            other.wait(lambda: ("last", "") in other.notifications, "what was sent afterwards")
            own = [script for script in other.scripts if script in ("first()", "second()")]
            assert own == ["first()", "second()"]
            assert not {"first()", "second()"} & set(one.scripts)


# ---- what it relies on


def test_viser_still_builds_its_server_the_way_the_door_expects():
    source = inspect.getsource(viser.infra.WebsockServer._background_worker)
    assert "websockets.asyncio.server.serve(" in source
    for option in ("process_request=", "max_size=", "select_subprotocol=", "compression=None"):
        assert option in source
    for name in ("_live_connections[client_id] = connection", "_client_state_from_id[client_id]"):
        assert f"self.{name}" in source
    assert (
        'if request.headers.get("Upgrade") == "websocket":\n                return None' in source
    )


def test_the_door_leaves_websockets_as_it_was(loopback):
    assert websockets.asyncio.server.serve.__module__ == "websockets.asyncio.server"
