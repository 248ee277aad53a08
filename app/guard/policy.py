"""The policy: who is let in, under which name, with which token, how often; and the headers.

Pure: it knows neither sockets nor viser. `app.guard.websockets` puts every request before it, and
`app.guard.start_check` makes sure of that before the server is announced.

The token is needed on loopback too: every user of a shared machine can connect there. A page of
another site may make a visitor's browser connect. It cannot hide its Origin nor, when its own name
resolves to this machine (DNS rebinding), the Host it believes to speak to.
"""

from __future__ import annotations

import ipaddress
import logging
import re
import time
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from http import HTTPStatus
from urllib.parse import parse_qs, urlsplit

from app.guard.limits import Limits, PeerRates
from app.guard.refusals import Refusals
from app.guard.token import Access
from llsrbm.errors import InputError

Header = tuple[str, str]
IPAddress = ipaddress.IPv4Address | ipaddress.IPv6Address

_log = logging.getLogger(__name__)

PATHS = ("/", "/index.html")
"""All that is served; the page is one file, and its WebSocket is opened where the page is."""

_METHODS = ("GET", "HEAD")
_HOST = re.compile(r"(\[[0-9a-f:.]+\]|[a-z0-9._-]+)(:\d{1,5})?")  # nothing that a header could end
_MAX_QUERY_FIELDS = 10

_HOW_TO_ENTER = (
    "open the address with ?token=... that was printed when the server was started, "
    "or see --token of llsrbm serve"
)

_ENTER_PAGE = """<!doctype html><html lang="en"><meta name="viewport" content="width=device-width">
<title>Jump designer: token needed</title>
<style>:root{color-scheme:light dark} body{font:16px/1.5 system-ui,sans-serif;max-width:34em;
margin:12vh auto;padding:0 1.2em} code{font-size:15px}</style>
<h1>This jump designer asks for its token</h1>
<p>It is in the address that <code>llsrbm serve</code> printed when it was started, and ends in
<code>?token=</code> and some letters. Ask whoever runs it for that address.</p>
<p>Open that address once in this browser, which then keeps the token. Then open your link again:
the design is in the link itself.</p></html>
"""

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


@dataclass(frozen=True)
class Request:
    """The head of an HTTP request."""

    method: str  # GET, HEAD, ...
    target: str  # path and query as they were sent
    headers: Mapping[str, tuple[str, ...]]  # name in lower case -> every value that came under it
    peer: str  # address of the other side

    @classmethod
    def of(cls, method: str, target: str, headers: Iterable[Header], peer: str) -> Request:
        """From the header lines in their order."""
        collected: dict[str, tuple[str, ...]] = {}
        for name, value in headers:
            collected[name.lower()] = (*collected.get(name.lower(), ()), value)
        return cls(method, target, collected, peer)

    def values(self, name: str) -> tuple[str, ...]:
        """All values of a header."""
        return self.headers.get(name, ())

    @property
    def host(self) -> str:
        """As the browser wrote it, in lower case; empty if there is none, or more than one."""
        values = self.values("host")
        return values[0].strip().lower() if len(values) == 1 else ""

    @property
    def upgrade(self) -> bool:
        """True if it wants to become a WebSocket."""
        wanted = ",".join(self.values("upgrade")).lower().split(",")
        return "websocket" in (name.strip() for name in wanted)

    @property
    def by_tls(self) -> bool:
        """True if a reverse proxy received it by TLS."""
        return self.values("x-forwarded-proto")[:1] == ("https",)


@dataclass(frozen=True)
class Decision:
    """The answer to a request."""

    # 101 lets it in as a WebSocket, 200 with the page; all others are answered with `body`
    status: HTTPStatus
    # the kind of refusal, never made of the visitor's text; empty if there is none
    reason: str = ""
    body: str = ""  # of the answer, unless it is the page or the WebSocket
    html: bool = False  # `body` is HTML instead of plain text
    headers: tuple[Header, ...] = ()  # of this answer, besides those of all
    delay: float = 0.0  # s before it is given


class Guard:
    """Decides about every request and records refusals; on the server's event loop alone."""

    def __init__(
        self,
        access: Access,  # the token, if one is needed
        # names under which browsers may reach the page, besides plain addresses
        hosts: Collection[str],
        *,
        loopback: bool,  # only this machine can reach the server
        # addresses and networks of reverse proxies: who they say that a request is of is believed
        proxies: Iterable[str] = (),
        limits: Limits | None = None,  # how much at a time
        now: Callable[[], float] = time.monotonic,  # s, a clock that never goes back
    ) -> None:
        self.access = access
        self.limits = limits = limits or Limits()
        self.refusals = Refusals(limits, now)
        self._hosts = frozenset(name.lower() for name in hosts) | {"localhost"}
        self._loopback = loopback
        self._proxies = tuple(map(_proxy, proxies))
        self._hinted = False
        peers = limits.peers
        self._handshakes = PeerRates(limits.handshakes_per_peer, peers, now, limits.handshakes)
        self._pages = PeerRates(limits.pages_per_peer, peers, now, limits.pages)
        self._wrong = PeerRates(limits.wrong_tokens, peers, now)

    def decide(self, request: Request, tabs: int = 0, of_peer: int = 0) -> Decision:
        """The answer to a request, given the open tabs that have sent something, and its peer's."""
        return (
            self._foreign(request)
            or self._nowhere(request)
            or self._unauthorised(request)
            or self._too_many(request, tabs, of_peer)
            or Decision(HTTPStatus.SWITCHING_PROTOCOLS if request.upgrade else HTTPStatus.OK)
        )

    def peer_of(self, address: str, forwarded: Iterable[str] = ()) -> str:
        """The peer that a request is of, sent by an address; `forwarded`: its X-Forwarded-For.

        Each proxy adds the address that it was reached from; what comes before the last one that
        is no proxy of ours, anybody may have made up.
        """
        peer = _address(address)
        listed = [part for value in forwarded for part in value.split(",")]
        while peer is not None and listed and any(peer in proxy for proxy in self._proxies):
            before = _address(listed.pop())
            if before is None:
                break
            peer = before
        if listed and not self._proxies and not self._hinted:
            self._hinted = True
            _log.warning(
                "requests come by a proxy at %s, whose visitors count as one; expected --proxy %s",
                *(peer, peer),
            )
        return network(address if peer is None else str(peer))

    def headers(self, host: str) -> tuple[Header, ...]:
        """Those of every answer; `host` is the request's, if it is a known one, else empty."""
        content = dict(_CONTENT)
        if _HOST.fullmatch(host):  # browsers before 2022 take 'self' for http alone
            content["connect-src"] += f" ws://{host} wss://{host}"
        policy = "; ".join(f"{name} {sources}" for name, sources in content.items())
        return (("Content-Security-Policy", policy), *_HEADERS)

    def note(self, peer: str, reason: str, detail: str = "") -> bool:
        """Record a refusal; only `detail` may be of the peer's text. True: first of its kind."""
        return self.refusals.note(network(peer), reason, detail)

    # ---- one question each: a decision if it ends there

    def _foreign(self, request: Request) -> Decision | None:
        """Refuse requests of another site's pages, and to names that are not ours."""
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
        if request.target.partition("?")[0] not in PATHS:
            return _refused(HTTPStatus.NOT_FOUND, "nothing there")
        return None

    def _unauthorised(self, request: Request) -> Decision | None:
        """Refuse requests without the token; turn the token in an address into a cookie."""
        if not self.access.required:
            if request.upgrade and not self._loopback and not request.values("origin"):
                return _refused(HTTPStatus.FORBIDDEN, "WebSocket without an Origin")
            return None
        host = request.host
        entitled = self.access.accepts_cookie(request.values("cookie"), host)
        tokens = _tokens(request)
        if request.upgrade or not tokens:
            return None if entitled else self._outside(request)
        if not entitled and (refusal := self._wrong_token(request, tokens)):
            return refusal
        # The address loses the token, so that nobody passes it on, and keeps its #fragment.
        headers: tuple[Header, ...] = (("Cache-Control", "no-store"),)
        if not entitled:
            headers += (("Set-Cookie", self.access.cookie(host, secure=request.by_tls)),)
        if _from_another_sites_link(request):
            return Decision(HTTPStatus.OK, body=_ASK_AGAIN, html=True, headers=headers)
        return Decision(HTTPStatus.SEE_OTHER, headers=(*headers, ("Location", "/")))

    def _wrong_token(self, request: Request, tokens: list[str]) -> Decision | None:
        """Refuse wrong tokens, beyond a rate of a peer after a while.

        The right one is heard at once, whatever else comes from there: a peer may be many people.
        """
        if len(tokens) == 1 and self.access.accepts_token(tokens[0]):
            return None
        refusal = _stay_outside(request, "wrong token")
        heard = self._wrong.take(network(request.peer))
        return refusal if heard else replace(refusal, delay=self.limits.wrong_token_s)

    def _outside(self, request: Request) -> Decision:
        if not request.upgrade and _from_another_sites_link(request):
            return Decision(HTTPStatus.UNAUTHORIZED, body=_ASK_AGAIN, html=True)
        return _stay_outside(request, "no token")

    def _too_many(self, request: Request, tabs: int, of_peer: int) -> Decision | None:
        """Refuse beyond the limits; only requests that were welcome use up the rates."""
        limits, later = self.limits, (("Retry-After", "1"),)
        if request.upgrade:
            for count, most, whose in (
                (tabs, limits.tabs, "at most"),
                (of_peer, limits.tabs_per_peer, "of one address at most"),
            ):
                if count >= most:
                    reason = f"too many open tabs ({whose} {most})"
                    return _refused(HTTPStatus.SERVICE_UNAVAILABLE, reason, headers=later)
        rates = self._handshakes if request.upgrade else self._pages
        if not rates.take(network(request.peer)):
            return _refused(HTTPStatus.TOO_MANY_REQUESTS, "too many requests", headers=later)
        return None


def network(peer: str) -> str:
    """One peer: an IPv4 address, or an IPv6 network of 64 bits."""
    address = _address(peer)
    if address is None:
        return "unknown"
    if isinstance(address, ipaddress.IPv4Address) or address.is_loopback:
        return str(address)
    return str(ipaddress.ip_network((address, 64), strict=False))


def _address(text: str) -> IPAddress | None:
    """The address in a text, which may have a port; None: there is none."""
    text = text.strip()
    if text.startswith("["):
        text = text[1:].partition("]")[0]
    elif text.count(":") == 1:
        text = text.partition(":")[0]
    try:
        address = ipaddress.ip_address(text.partition("%")[0])
    except ValueError:
        return None
    return getattr(address, "ipv4_mapped", None) or address


def _proxy(text: str) -> ipaddress.IPv4Network | ipaddress.IPv6Network:
    try:
        return ipaddress.ip_network(text)
    except ValueError as error:
        raise InputError(
            f"--proxy: expected an address or a network, for example 127.0.0.1 or 10.0.0.0/8, got "
            f"{text!r:.80}"
        ) from error


def _stay_outside(request: Request, reason: str) -> Decision:
    """The refusal of who has no token: for a browser a page in words, else a line."""
    refusal = _refused(HTTPStatus.UNAUTHORIZED, reason, _HOW_TO_ENTER)
    if request.values("sec-fetch-dest") != ("document",):
        return refusal
    return replace(refusal, body=_ENTER_PAGE, html=True)


def _refused(
    status: HTTPStatus, reason: str, advice: str = "", *, headers: tuple[Header, ...] = ()
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
