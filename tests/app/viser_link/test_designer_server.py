"""What the guard promises, and what it relies on in viser."""

from __future__ import annotations

import http.client
import inspect
from collections import deque

import pytest
import viser
import websockets
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from app.viser_link.designer_server import MAX_CONNECTIONS, DesignerServer, refusal, run_javascript
from tests.app.raw_tab import RawTab

PROTOCOL = [f"viser-v{viser.__version__}"]
NAMES = {"localhost"}


def get(port, host):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    connection.putrequest("GET", "/", skip_host=True)
    for value in host:
        connection.putheader("Host", value)
    connection.endheaders()
    response = connection.getresponse()
    return response.status, response.read()


@pytest.mark.parametrize("host", ["127.0.0.1:{}", "localhost:{}", "[::1]:{}", "192.168.1.7:9000"])
def test_the_page_is_served_under_addresses_and_known_names(designer, host):
    status, body = get(designer.port, [host.format(designer.port)])
    assert status == 200
    assert b"<html" in body.lower()


@pytest.mark.parametrize(
    ("host", "why"),
    [
        (["evil.example"], b"unknown host 'evil.example'; start with --allow-host evil.example"),
        ([], b"unknown host ''"),
        (["127.0.0.1", "evil.example"], b"ambiguous Host or Origin"),
        (["[::1"], b"cannot be read"),
    ],
)
def test_another_host_is_refused(designer, host, why):
    status, body = get(designer.port, host)
    assert status == 403
    assert why in body


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:1"])
def test_a_page_of_another_site_cannot_connect(designer, origin):
    with pytest.raises(InvalidStatus) as refused:
        connect(f"ws://127.0.0.1:{designer.port}", origin=origin, subprotocols=PROTOCOL)
    assert refused.value.response.status_code == 403
    assert b"request from another site" in refused.value.response.body


def test_the_own_page_connects(designer):
    address = f"127.0.0.1:{designer.port}"
    with connect(f"ws://{address}", origin=f"http://{address}", subprotocols=PROTOCOL):
        pass


def test_a_large_message_closes_the_connection(designer):
    with connect(f"ws://127.0.0.1:{designer.port}", subprotocols=PROTOCOL, max_size=None) as socket:
        socket.send(bytes(2 << 20))
        with pytest.raises(ConnectionClosed) as closed:
            deque(iter(lambda: socket.recv(timeout=10), None), maxlen=0)
    assert closed.value.rcvd.code == 1009


def test_the_number_of_tabs_is_limited():
    assert refusal("localhost", None, MAX_CONNECTIONS - 1, NAMES) is None
    assert "too many open tabs" in refusal("localhost", None, MAX_CONNECTIONS, NAMES)


def test_open_connections_are_counted(designer, monkeypatch):
    counted = []
    monkeypatch.setattr(
        "app.viser_link.designer_server.refusal", lambda *arguments: counted.append(arguments[2])
    )
    address = f"ws://127.0.0.1:{designer.port}"
    with connect(address, subprotocols=PROTOCOL), connect(address, subprotocols=PROTOCOL):
        pass
    assert counted[1] == counted[0] + 1


def test_a_behind_proxy_name_works_with_its_origin():
    assert refusal("jumps.example", "https://jumps.example", 0, {"jumps.example"}) is None


def test_no_client_can_open_a_tunnel(designer):
    assert DesignerServer.request_share_url is not viser.ViserServer.request_share_url
    assert designer._server.request_share_url() is None


def test_a_script_reaches_its_tab_and_no_other(designer):
    with RawTab(designer.port) as one:
        one.wait_for_status("Planned")
        known = designer._server.get_clients().keys()
        with RawTab(designer.port) as other:
            other.wait_for_status("Planned")
            (client,) = (
                client for key, client in designer._server.get_clients().items() if key not in known
            )
            run_javascript(client, "first()")
            run_javascript(client, "second()")
            client.add_notification("last", "")
            other.wait(lambda: ("last", "") in other.notifications, "what was sent afterwards")
            assert other.scripts[-2:] == ["first()", "second()"]
            assert not {"first()", "second()"} & set(one.scripts)


def test_viser_still_builds_its_server_the_way_the_guard_expects():
    source = inspect.getsource(viser.infra.WebsockServer._background_worker)
    assert "websockets.asyncio.server.serve(" in source
    assert "process_request=" in source
    assert "max_size=" in source


def test_the_guard_leaves_websockets_as_it_was(designer):
    assert websockets.asyncio.server.serve.__module__ == "websockets.asyncio.server"
