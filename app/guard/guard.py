"""The policy: who is let in, under which name, with which token, how often; and the headers.

Pure: it knows neither sockets nor viser. `app.guard` puts every request before it, and
`app.guard.self_check` makes sure of that before the server is announced.

On loopback there is no token by default: who may connect there may read this user's screen too.
A page of another site may still make the user's browser connect. It cannot hide its Origin nor,
when its own name resolves to this machine (DNS rebinding), the Host it believes to speak to.
"""

from __future__ import annotations

import ipaddress
import re
import time
from collections import OrderedDict
from collections.abc import Callable, Collection
from http import HTTPStatus
from urllib.parse import parse_qs, urlsplit

from app.guard.access import Access
from app.guard.entry import Decision, Request
from app.guard.limits import Limits, Rate, TokenBucket
from app.guard.refusals import Refusals

PATHS = ("/", "/index.html")
"""All that is served; the page is one file, and its WebSocket is opened where the page is."""

_METHODS = ("GET", "HEAD")
_HOST = re.compile(r"(\[[0-9a-f:.]+\]|[a-z0-9._-]+)(:\d{1,5})?")  # nothing that a header could end
_MAX_QUERY_FIELDS = 10

_HOW_TO_ENTER = (
    "open the address with ?token=... that was printed when the server was started, "
    "or see --token of llsrbm serve"
)

# A cookie of our kind is not sent with a request that another site's link has made, so that a
# browser which has one would stand outside. This page asks again, of its own accord; without the
# question mark its address could be the one it has, and nothing would be asked.
_ASK_AGAIN = (
    "<!doctype html><title>Jump designer</title>"
    '<script>location.replace("/?" + location.hash)</script>\n'
)

# viser's page unpacks itself into an inline script and an inline style, compiles WebAssembly, runs
# scripts that its server sends (`new Function`), and talks to its server from a worker of its own.
_CONTENT = {
    "default-src": "'none'",
    "script-src": "'self' 'unsafe-inline' 'unsafe-eval' blob:",
    "style-src": "'unsafe-inline'",
    "img-src": "'self' data: blob:",
    "font-src": "data:",
    "media-src": "data: blob:",
    "worker-src": "blob: data:",
    "connect-src": "'self' data: blob:",
    "frame-src": "'none'",
    "frame-ancestors": "'none'",
    "base-uri": "'none'",
    "form-action": "'none'",
    "object-src": "'none'",
}

_UNUSED = (
    "accelerometer", "autoplay", "bluetooth", "camera", "display-capture", "geolocation",
    "gyroscope", "hid", "magnetometer", "microphone", "midi", "payment", "serial", "usb",
)  # fmt: skip

_HEADERS = (
    ("X-Content-Type-Options", "nosniff"),
    ("X-Frame-Options", "DENY"),
    ("Referrer-Policy", "no-referrer"),
    ("Cross-Origin-Opener-Policy", "same-origin"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("Permissions-Policy", ", ".join(f"{name}=()" for name in _UNUSED)),
)


class Guard:
    """Decides about every request; a `Gate` of `app.guard`."""

    def __init__(
        self,
        access: Access,
        hosts: Collection[str],
        *,
        loopback: bool,
        limits: Limits | None = None,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        """Nothing is let in by default.

        Args:
            access: the token, if one is needed.
            hosts: names under which browsers may reach the page, besides plain addresses.
            loopback: whether only this machine can reach the server.
            limits: how much at a time.
            now: s, a clock that never goes back.
        """
        self.access = access
        self.limits = limits or Limits()
        self.refusals = Refusals(self.limits, now)
        self._hosts = frozenset(name.lower() for name in hosts) | {"localhost"}
        self._loopback = loopback
        limits = self.limits
        self._handshakes = _Rates(limits.handshakes, limits.handshakes_per_peer, limits.peers, now)
        self._pages = _Rates(limits.pages, limits.pages_per_peer, limits.peers, now)

    def decide(self, request: Request, tabs: int) -> Decision:
        """Decide about a request (see `Gate`)."""
        return (
            self._foreign(request)
            or self._nowhere(request)
            or self._unauthorised(request)
            or self._too_many(request, tabs)
            or Decision(HTTPStatus.SWITCHING_PROTOCOLS if request.upgrade else HTTPStatus.OK)
        )

    def headers(self, host: str) -> tuple[tuple[str, str], ...]:
        """Those of every answer."""
        content = dict(_CONTENT)
        if _HOST.fullmatch(host):  # browsers before 2022 take 'self' for http alone
            content["connect-src"] += f" ws://{host} wss://{host}"
        policy = "; ".join(f"{name} {sources}" for name, sources in content.items())
        return (("Content-Security-Policy", policy), *_HEADERS)

    def note(self, peer: str, reason: str, detail: str = "") -> bool:
        """Note down that something was refused; true if it is the first of its kind."""
        return self.refusals.note(network(peer), reason, detail)

    # ---- one question each: a decision if it ends there

    def _foreign(self, request: Request) -> Decision | None:
        """Whether it comes from a page of another site, or believes to speak to one."""
        if request.method not in _METHODS:
            allow = (("Allow", ", ".join(_METHODS)),)
            return _refused(
                HTTPStatus.METHOD_NOT_ALLOWED, "method", f"expected {allow[0][1]}", headers=allow
            )
        origins = request.values("origin")
        if len(request.values("host")) > 1 or len(origins) > 1:
            return _refused(HTTPStatus.FORBIDDEN, "ambiguous Host or Origin")
        found = _HOST.fullmatch(request.host)
        if found is None:
            return _refused(HTTPStatus.FORBIDDEN, "Host that is missing or cannot be read")
        name = found[1].strip("[]")
        if name not in self._hosts and not _is_address(name):
            advice = f"{name!r}; start with --allow-host {name} to serve it"
            return _refused(HTTPStatus.FORBIDDEN, "unknown host", advice)
        if origins and _netloc(origins[0]) != request.host:
            return _refused(HTTPStatus.FORBIDDEN, "request from another site")
        if request.upgrade and "cross-site" in request.values("sec-fetch-site"):
            return _refused(HTTPStatus.FORBIDDEN, "request from another site")
        return None

    def _nowhere(self, request: Request) -> Decision | None:
        """Whether it asks for anything but the page."""
        if request.target.partition("?")[0] not in PATHS:
            return _refused(HTTPStatus.NOT_FOUND, "nothing there")
        return None

    def _unauthorised(self, request: Request) -> Decision | None:
        """Whether it comes without the token, or has just brought it."""
        if not self.access.required:
            if request.upgrade and not self._loopback and not request.values("origin"):
                return _refused(HTTPStatus.FORBIDDEN, "WebSocket without an Origin")
            return None
        host = request.host
        entitled = self.access.accepts_cookie(request.values("cookie"), host)
        tokens = _tokens(request)
        if request.upgrade or not tokens:
            return None if entitled else self._outside(request)
        if not entitled and not (len(tokens) == 1 and self.access.accepts_token(tokens[0])):
            return _refused(HTTPStatus.UNAUTHORIZED, "wrong token", _HOW_TO_ENTER)
        # The address loses the token, so that nobody passes it on, and keeps its #fragment.
        headers: tuple[tuple[str, str], ...] = (("Cache-Control", "no-store"),)
        if not entitled:
            headers += (("Set-Cookie", self.access.cookie(host)),)
        if _from_another_sites_link(request):
            return Decision(HTTPStatus.OK, body=_ASK_AGAIN, html=True, headers=headers)
        return Decision(HTTPStatus.SEE_OTHER, headers=(*headers, ("Location", "/")))

    def _outside(self, request: Request) -> Decision:
        if not request.upgrade and _from_another_sites_link(request):
            return Decision(HTTPStatus.UNAUTHORIZED, body=_ASK_AGAIN, html=True)
        return _refused(HTTPStatus.UNAUTHORIZED, "no token", _HOW_TO_ENTER)

    def _too_many(self, request: Request, tabs: int) -> Decision | None:
        """Whether it comes too often; only those that were welcome use up what is left."""
        later = (("Retry-After", "1"),)
        if request.upgrade and tabs >= self.limits.tabs:
            return _refused(
                HTTPStatus.SERVICE_UNAVAILABLE,
                f"too many open tabs (at most {self.limits.tabs})",
                headers=later,
            )
        rates = self._handshakes if request.upgrade else self._pages
        if not rates.take(network(request.peer)):
            return _refused(HTTPStatus.TOO_MANY_REQUESTS, "too many requests", headers=later)
        return None


class _Rates:
    """One bucket for all and one for each of the peers that were seen last."""

    def __init__(self, in_all: Rate, each: Rate, peers: int, now: Callable[[], float]) -> None:
        self._all = TokenBucket(in_all, now)
        self._each, self._peers, self._now = each, peers, now
        self._of: OrderedDict[str, TokenBucket] = OrderedDict()

    def take(self, peer: str) -> bool:
        bucket = self._of.pop(peer, None) or TokenBucket(self._each, self._now)
        self._of[peer] = bucket
        while len(self._of) > self._peers:
            self._of.popitem(last=False)
        return bucket.take() and self._all.take()


def network(peer: str) -> str:
    """One peer: an IPv4 address, or an IPv6 network of 64 bits."""
    try:
        address = ipaddress.ip_address(peer.partition("%")[0])
    except ValueError:
        return "unknown"
    if isinstance(address, ipaddress.IPv4Address):
        return str(address)
    if address.ipv4_mapped is not None:
        return str(address.ipv4_mapped)
    if address.is_loopback:
        return str(address)
    return str(ipaddress.ip_network((address, 64), strict=False))


def _refused(
    status: HTTPStatus, reason: str, advice: str = "", *, headers: tuple[tuple[str, str], ...] = ()
) -> Decision:
    line = f"{reason}: {advice}" if advice else reason
    return Decision(status, reason, f"refused: {line}\n", headers=headers)


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _netloc(origin: str) -> str | None:
    try:
        return urlsplit(origin).netloc.lower()
    except ValueError:
        return None


def _tokens(request: Request) -> list[str]:
    query = request.target.partition("?")[2]
    try:
        fields = parse_qs(query, keep_blank_values=True, max_num_fields=_MAX_QUERY_FIELDS)
    except ValueError:
        return []
    return fields.get("token", [])


def _from_another_sites_link(request: Request) -> bool:
    fetch = (request.values(f"sec-fetch-{name}") for name in ("site", "mode", "dest"))
    return tuple(fetch) == (("cross-site",), ("navigate",), ("document",))
