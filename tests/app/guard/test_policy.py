"""The policy alone: requests as values, and a clock that is the test's."""

import re
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.guard.limits import Limits, Rate, TokenBucket
from app.guard.policy import Guard, Request, network
from app.guard.token import Access
from llsrbm.errors import InputError
from tests.app.guard.clock import Clock

TOKEN = "a-token-of_32-characters-exactly"
HOST = "10.0.0.1:8080"
OWN = (("Host", HOST),)
SOCKET = (("Upgrade", "websocket"), ("Connection", "Upgrade"))
ORIGIN = (("Origin", f"http://{HOST}"),)


def guard(token=None, *, loopback=True, limits=None, now=None):
    access = Access(token, 8080)
    clock = now or Clock()
    return Guard(access, {"Jumps.example"}, loopback=loopback, limits=limits, now=clock)


def request(*headers, target="/", method="GET", peer="10.0.0.9"):
    return Request.of(method, target, headers, peer)


def status(guard, *headers, tabs=0, of_peer=0, **given):
    return int(guard.decide(request(*headers, **given), tabs, of_peer).status)


def cookie(guard, host=HOST):
    return (("Cookie", guard.access.cookie(host).partition(";")[0]),)


LOOPBACK = pytest.param(guard(), (), id="loopback")
WITH_TOKEN = guard(TOKEN, loopback=False)
OUTSIDE = pytest.param(WITH_TOKEN, cookie(WITH_TOKEN), id="off loopback")
EVERYBODY = pytest.param(guard(loopback=False), (), id="off loopback, no token")
ALL = pytest.mark.parametrize(("guard", "enter"), [LOOPBACK, OUTSIDE, EVERYBODY])


@ALL
def test_the_own_page_is_let_in(guard, enter):
    for target in ("/", "/index.html", "/?websocket=ws://evil.example"):
        assert status(guard, *OWN, *enter, target=target) == 200
        assert status(guard, *OWN, *enter, target=target, method="HEAD") == 200
    assert status(guard, *OWN, *enter, *SOCKET, *ORIGIN) == 101


@ALL
@pytest.mark.parametrize(
    ("host", "expected"),
    [
        ("127.0.0.1:1", 401),
        ("[::1]:8080", 401),
        ("LOCALHOST:8080", 401),
        ("jumps.example", 401),
        ("evil.example", 403),
        ("evil.example:8080", 403),
        ("127.0.0.1.evil.example", 403),
        ("user@127.0.0.1", 403),
        ("127.0.0.1:8080@evil.example", 403),
        ("127.0.0.1:port", 403),
        ("127.0.0.1; script-src *", 403),
        ("[::1", 403),
        ("", 403),
    ],
)
def test_unknown_names_are_refused(guard, enter, host, expected):
    welcome = 200 if not enter else expected  # its cookie is another host's
    for headers in ((), SOCKET):
        got = status(guard, ("Host", host), *enter, *headers)
        assert got == 403 if expected == 403 else got in (welcome, 101, 403)
    assert status(guard, ("Host", host), *enter) == (403 if expected == 403 else welcome)


@ALL
@pytest.mark.parametrize(
    "headers",
    [
        (),
        (("Host", HOST), ("Host", "evil.example")),  # of two none is believed
        (("Host", HOST), ("Host", HOST)),
        (*OWN, ("Origin", f"http://{HOST}"), ("Origin", "http://evil.example")),
        (*OWN, ("Origin", "http://evil.example")),
        (*OWN, ("Origin", "null")),
        (*OWN, ("Origin", "")),
        (*OWN, ("Origin", "http://10.0.0.1")),
        (*OWN, ("Origin", "http://10.0.0.1:8081")),
        (*OWN, ("Origin", "http://[")),
    ],
)
def test_pages_of_other_sites_are_refused(guard, enter, headers):
    assert status(guard, *headers, *enter) == 403
    assert status(guard, *headers, *enter, *SOCKET) == 403


@ALL
def test_a_websocket_of_another_sites_page_is_refused_whatever_its_origin(guard, enter):
    fetch = ("Sec-Fetch-Site", "cross-site")
    assert status(guard, *OWN, *enter, *SOCKET, *ORIGIN, fetch) == 403
    assert status(guard, *OWN, *enter, fetch) == 200  # a link


@ALL
@pytest.mark.parametrize(
    "target",
    [
        "/assets/x.js", "/../etc/passwd", "/%2e%2e/etc/passwd", "//evil.example/", "",
        "/index.html/", "http://evil.example/", "/" + "x" * 8000,
    ],
)  # fmt: skip
def test_nothing_but_the_page_is_there(guard, enter, target):
    assert status(guard, *OWN, *enter, target=target) == 404
    assert status(guard, *OWN, *enter, *SOCKET, *ORIGIN, target=target) == 404


@ALL
@pytest.mark.parametrize("method", ["POST", "PUT", "OPTIONS", "CONNECT", "get", ""])
def test_only_get_and_head(guard, enter, method):
    assert status(guard, *OWN, *enter, method=method) == 405


def test_without_the_token_nobody_enters():
    outside = guard(TOKEN, loopback=False)
    for target in ("/", "/?token=", f"/?token={TOKEN}x", f"/?token={TOKEN}&token=x"):
        decision = outside.decide(request(*OWN, target=target))
        assert decision.status == 401
        assert decision.body.count("\n") == 1
        assert "?token=" in decision.body
        assert TOKEN not in decision.body
    assert status(outside, *OWN, *SOCKET, *ORIGIN) == 401
    # Not even with it: a WebSocket's address is seen in many places.
    assert status(outside, *OWN, *SOCKET, *ORIGIN, target=f"/?token={TOKEN}") == 401


def test_the_token_becomes_a_cookie_and_leaves_the_address():
    outside = guard(TOKEN, loopback=False)
    decision = outside.decide(request(*OWN, target=f"/?a=b&token={TOKEN}"), 0)
    headers = dict(decision.headers)
    assert (decision.status, headers["Location"], headers["Cache-Control"]) == (
        303,
        "/",
        "no-store",
    )
    got = (("Cookie", headers["Set-Cookie"].partition(";")[0]),)
    assert status(outside, *OWN, *got) == 200
    assert status(outside, *OWN, *got, *SOCKET, *ORIGIN) == 101
    assert status(outside, *OWN, *got, *SOCKET) == 101  # no browser
    # Opened again, from a bookmark: the address shall still lose it.
    again = outside.decide(request(*OWN, *got, target="/?token=old"), 0)
    assert again.status == 303
    assert "Set-Cookie" not in dict(again.headers)


def test_wrong_tokens_are_answered_late_and_keep_no_right_one_out():
    """Behind a proxy all people are one peer."""
    clock = Clock()
    outside = guard(TOKEN, loopback=False, now=clock)

    def enter(token):
        decision = outside.decide(request(*OWN, target=f"/?token={token}"))
        return int(decision.status), decision.delay

    assert [enter("wrong") for _ in range(12)] == [(401, 0.0)] * 10 + [(401, 5.0)] * 2
    for _ in range(100):
        enter("wrong")
        assert enter(TOKEN) == (303, 0.0)
    clock.now += 5.0
    assert [enter("wrong") for _ in range(2)] == [(401, 0.0), (401, 5.0)]


@pytest.mark.parametrize(
    ("address", "forwarded", "peer"),
    [
        ("10.0.0.9", ["203.0.113.7"], "10.0.0.9"),  # anybody can write that
        ("127.0.0.1", [], "127.0.0.1"),
        ("127.0.0.1", ["203.0.113.7"], "203.0.113.7"),
        ("::ffff:127.0.0.1", ["203.0.113.7:4711"], "203.0.113.7"),
        ("127.0.0.1", ["2001:db8::1"], "2001:db8::/64"),
        ("127.0.0.1", ["[2001:db8::1]:80"], "2001:db8::/64"),
        # The proxy adds the last one; a visitor may have made up the others.
        ("127.0.0.1", ["198.51.100.1, 203.0.113.7"], "203.0.113.7"),
        ("127.0.0.1", ["198.51.100.1", "203.0.113.7"], "203.0.113.7"),
        ("127.0.0.1", ["198.51.100.1, 203.0.113.7, 10.1.2.3"], "203.0.113.7"),
        ("127.0.0.1", ["203.0.113.7, unknown"], "127.0.0.1"),
        ("127.0.0.1", ["", "10.1.2.3"], "10.1.2.3"),
    ],
)
def test_a_known_proxy_says_who_a_request_is_of(address, forwarded, peer):
    proxied = Guard(Access(None), (), loopback=True, proxies=("127.0.0.1", "10.1.0.0/16"))
    assert proxied.peer_of(address, forwarded) == peer


def test_a_proxy_that_is_not_known_is_one_line(caplog):
    plain = guard()
    for _ in range(3):
        assert plain.peer_of("10.1.2.3", ["203.0.113.7"]) == "10.1.2.3"
    (line,) = caplog.messages
    assert line.endswith("expected --proxy 10.1.2.3")
    with pytest.raises(InputError, match="--proxy: expected an address or a network"):
        Guard(Access(None), (), loopback=True, proxies=("proxy.example",))


def test_behind_tls_the_cookie_is_secure():
    outside = guard(TOKEN)
    for headers, secure in (((), False), ((("X-Forwarded-Proto", "https"),), True)):
        decision = outside.decide(request(*OWN, *headers, target=f"/?token={TOKEN}"))
        assert ("; Secure" in dict(decision.headers)["Set-Cookie"]) is secure


def test_a_replayed_cookie_is_refused():
    former, outside = guard("former-" + TOKEN, loopback=False), guard(TOKEN, loopback=False)
    assert status(outside, *OWN, *cookie(former)) == 401
    assert status(outside, *OWN, *cookie(outside, "10.0.0.2:8080")) == 401
    assert status(outside, *OWN, *cookie(former), *SOCKET, *ORIGIN) == 401


LINK = (("Sec-Fetch-Site", "cross-site"), ("Sec-Fetch-Mode", "navigate"),
        ("Sec-Fetch-Dest", "document"))  # fmt: skip


def test_a_link_on_another_site_leads_in_too():
    outside = guard(TOKEN, loopback=False)
    # The browser would not send a cookie of ours along a redirection from there.
    first = outside.decide(request(*OWN, *LINK, target=f"/?token={TOKEN}"), 0)
    assert first.status == 200
    assert "Set-Cookie" in dict(first.headers)
    assert "location.replace" in first.body
    # Nor with a link to the page itself.
    known = outside.decide(request(*OWN, *LINK), 0)
    assert known.status == 401
    assert "location.replace" in known.body
    assert "location.replace" not in outside.decide(request(*OWN), 0).body


def test_off_loopback_without_a_token_a_websocket_needs_an_origin():
    assert status(guard(loopback=False), *OWN, *SOCKET) == 403
    assert status(guard(loopback=True), *OWN, *SOCKET) == 101


@ALL
def test_the_number_of_tabs_is_limited(guard, enter):
    headers = (*OWN, *enter, *SOCKET, *ORIGIN)
    assert status(guard, *headers, tabs=guard.limits.tabs - 1) == 101
    decision = guard.decide(request(*headers), guard.limits.tabs)
    assert decision.status == 503
    assert "too many open tabs (at most 50)" in decision.body
    crowd = guard.limits.tabs_per_peer
    assert status(guard, *headers, tabs=crowd, of_peer=crowd - 1) == 101
    assert status(guard, *headers, tabs=crowd, of_peer=crowd) == 503
    assert status(guard, *OWN, *enter, tabs=guard.limits.tabs) == 200


@pytest.mark.parametrize("headers", [(), (*SOCKET, *ORIGIN)])
def test_requests_are_limited_in_all_and_for_each_peer(headers):
    rates = Rate(10, 5), Rate(1, 2)
    limits = replace(
        Limits(), pages=rates[0], pages_per_peer=rates[1],
        handshakes=rates[0], handshakes_per_peer=rates[1],
    )  # fmt: skip
    clock = Clock()
    busy = guard(limits=limits, now=clock)

    def ask(peer):
        return status(busy, *OWN, *headers, peer=peer)

    welcome = 101 if headers else 200
    assert [ask("10.0.0.1") for _ in range(3)] == [welcome, welcome, 429]
    clock.now += 1.0
    assert [ask("10.0.0.1") for _ in range(2)] == [welcome, 429]
    assert [ask(f"10.0.1.{i}") for i in range(6)] == [welcome] * 4 + [429] * 2
    assert dict(busy.decide(request(*OWN, *headers), 0).headers)["Retry-After"] == "1"


def test_refused_requests_use_nothing_up():
    limits = replace(Limits(), handshakes=Rate(1, 2), handshakes_per_peer=Rate(1, 2))
    busy = guard(limits=limits)
    for _ in range(100):  # a page of another site, in the browser of who uses this one
        assert status(busy, *OWN, *SOCKET, ("Origin", "http://evil.example")) == 403
    assert status(busy, *OWN, *SOCKET, *ORIGIN) == 101


def test_peers_are_forgotten():
    busy = guard(limits=replace(Limits(), peers=10))
    for i in range(100):
        status(busy, *OWN, peer=f"10.0.1.{i}")
    assert len(busy._pages._of) == 10


@pytest.mark.parametrize(
    ("peer", "expected"),
    [
        ("10.0.0.1", "10.0.0.1"),
        ("::ffff:10.0.0.1", "10.0.0.1"),
        ("2001:db8:1:2:3:4:5:6", "2001:db8:1:2::/64"),
        ("fe80::1%eth0", "fe80::/64"),
        ("::1", "::1"),
        ("nonsense", "unknown"),
    ],
)
def test_what_counts_as_one_peer(peer, expected):
    assert network(peer) == expected


def test_headers_forbid_what_the_page_does_not_need():
    headers = dict(guard().headers("10.0.0.1:8080"))
    content = dict(part.split(" ", 1) for part in headers["Content-Security-Policy"].split("; "))
    for name in ("default-src", "frame-ancestors", "base-uri", "form-action", "object-src"):
        assert content[name] == "'none'"
    assert content["connect-src"] == "'self' data: blob: ws://10.0.0.1:8080 wss://10.0.0.1:8080"
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["X-Frame-Options"] == "DENY"
    assert headers["Referrer-Policy"] == "no-referrer"
    assert headers["Cross-Origin-Opener-Policy"] == "same-origin"
    assert headers["Cross-Origin-Resource-Policy"] == "same-origin"
    assert "camera=()" in headers["Permissions-Policy"]
    assert "clipboard" not in headers["Permissions-Policy"]


ANY = st.tuples(
    st.sampled_from(["Host", "Origin", "Cookie", "Upgrade", "Sec-Fetch-Site", "Connection", "X"]),
    st.sampled_from([HOST, f"http://{HOST}", "websocket", "cross-site", "llsrbm-8080=1.2", ""])
    | st.text(max_size=20),
)


@given(st.lists(ANY, max_size=6), st.text(max_size=30), st.sampled_from(["GET", "HEAD", "POST"]))
def test_whatever_comes_nobody_enters_without_the_token(headers, target, method):
    outside = guard(TOKEN, loopback=False)
    decision = outside.decide(request(*headers, target=target, method=method), 0)
    assert decision.status >= 400
    assert decision.reason or decision.html
    for name, value in (*decision.headers, *outside.headers("x y")):
        assert re.fullmatch(r"[\x20-\x7e]+", name + value)


# ---- rates


def test_a_burst_then_the_rate():
    clock = Clock()
    bucket = TokenBucket(Rate(2.0, 3.0), clock)
    assert [bucket.take() for _ in range(4)] == [True, True, True, False]
    clock.now += 0.5
    assert [bucket.take() for _ in range(2)] == [True, False]
    clock.now += 100.0
    assert [bucket.take() for _ in range(4)] == [True, True, True, False]


def test_what_waits_comes_at_the_rate():
    clock = Clock()
    bucket = TokenBucket(Rate(2.0, 3.0), clock)
    assert [bucket.wait() for _ in range(5)] == pytest.approx([0, 0, 0, 0.5, 1.0])


@given(st.lists(st.floats(0, 2), max_size=50))
def test_never_more_than_burst_and_rate_allow(pauses):
    clock = Clock()
    bucket = TokenBucket(Rate(3.0, 4.0), clock)
    taken = 0
    for pause in pauses:
        clock.now += pause
        taken += bucket.take()
        assert taken <= 4 + 3 * (clock.now - 100.0) + 1e-6


def test_a_browser_without_a_token_is_told_in_words_and_a_program_in_a_line():
    outside = guard(TOKEN, loopback=False)
    typed = (("Sec-Fetch-Site", "none"), ("Sec-Fetch-Mode", "navigate"),
             ("Sec-Fetch-Dest", "document"))  # fmt: skip
    for target, reason in (("/", "no token"), ("/?token=wrong", "wrong token")):
        told = outside.decide(request(*OWN, *typed, target=target), 0)
        line = outside.decide(request(*OWN, target=target), 0)
        assert (told.status, told.reason, told.html) == (401, reason, True)
        assert "asks for its token" in told.body
        assert (line.status, line.html) == (401, False)
        assert line.body.startswith(f"refused: {reason}: ")
        assert TOKEN not in told.body + line.body
