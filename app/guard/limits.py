"""Limits of everything that visitors may do to the server, each with its unit and its reason."""

import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

UPLOAD_PART = 512 * 1024  # Bytes of an uploaded file that come at once, as viser's page sends them

MAX_UPLOAD = 40 * UPLOAD_PART
"""Bytes of an uploaded file; a simulation of some seconds takes a twentieth of it."""

LONGEST_TEXT = 150_000
"""Characters of a message of the page's scripts: a stored design and one from a link."""


@dataclass(frozen=True)
class Rate:
    """A rate per second in the long run, and a burst after a pause."""

    per_second: float
    burst: float


@dataclass(frozen=True)
class Limits:
    """A peer is one IPv4 address, or one IPv6 network of 64 bits, which one customer gets.

    Of a request that a known reverse proxy passes on, it is the address that the proxy names.
    Several people may share a peer (an office, a proxy that is not known), so a peer's rates are
    enough for all tabs to come back at once after a restart.
    """

    # ---- entering
    tabs: int = 50
    """Open at a time; each costs a thread and some megabytes. When all are open, the oldest that
    has sent nothing is closed."""

    tabs_per_peer: int = 40  # A class of thirty behind one address; other peers find room even then

    first_message_s: float = 20.0
    """Until a tab sends its first message; a page does so when it is first drawn."""

    pending: int = 128
    """Connections that are no tab (yet): asking, or being answered. A page takes 0.6 MB of memory
    while it is being sent, so these take at most 80 MB. The oldest of the peer with most of them
    is cut for the next one."""

    open_s: float = 30.0
    """Until a request is complete and answered: the page is 0.6 MB, over 0.2 Mbit/s 25 s."""

    close_s: float = 3.0  # For a peer to agree to the end of a connection; then it is cut

    handshakes: Rate = Rate(50.0, 150.0)
    """Tabs that are opened, in all. A tab that lost its connection tries about once a second."""

    handshakes_per_peer: Rate = Rate(20.0, 100.0)
    """Tabs that are opened by a peer: twice all tabs at once."""

    pages: Rate = Rate(50.0, 150.0)  # Requests of the page, in all; one takes 1 ms and 0.6 MB

    pages_per_peer: Rate = Rate(20.0, 100.0)  # Requests of the page by a peer

    wrong_tokens: Rate = Rate(0.2, 10.0)  # By a peer, that are answered at once

    wrong_token_s: float = 5.0
    """Until further wrong tokens are answered. They keep no right one out, of whatever peer."""

    peers: int = 1000
    """Of which rates are remembered; the one that was silent longest is forgotten first."""

    # ---- messages of a tab
    message_bytes: int = 1 << 20  # At once: a part of a file takes half of it

    value_bytes: int = 4 << 10
    """Of a control's value, and of any other message that is no part of a file."""

    fragments: int = 4096
    """Of one message: a browser cuts a part of a file into at most some hundred."""

    messages: Rate = Rate(200.0, 400.0)
    """Faster ones wait unread, and the tab's network with them, in order. Each 128 kB count as one
    more. A page sends 20 changes of its controls a second and 50 of its camera, and a file of 40
    parts."""

    flood_s: float = 5.0
    """For which messages may have to wait without a pause; then the tab is closed. Pages that were
    stopped for a while, a laptop's lid, come with some hundred messages and are through in 2 s."""

    controls: Rate = Rate(10.0, 100.0)
    """Pings and pongs of WebSocket itself; a browser only answers ours, three a minute."""

    upload_bytes: int = 3 * MAX_UPLOAD  # Of unfinished files of all tabs together

    upload_idle_s: float = 10.0  # Between two parts of a file

    # ---- messages to a tab
    backlog_bytes: int = 64 << 20
    """Waiting for one tab: ten times all meshes of a robot with its motion."""

    socket_bytes: int = 256 << 10
    """Kept by the system for a connection (Linux takes twice as much). It would take 4 MB, and not
    show for minutes that a slow peer reads; this is 2 MB/s at a round trip of 0.2 s."""

    stalled_s: float = 20.0
    """In which a tab takes nothing of what waits for it, or does not answer a ping; then it is
    closed, and reconnects when it can. A poor wireless network pauses for some seconds."""

    # ---- the log
    first_lines: int = 20
    """Lines a minute about refusals of a new kind or a new peer; the others are counted."""

    summary_s: float = 60.0  # Between two summaries of the refusals in the meantime

    refusals: int = 500  # Peers and reasons that are counted apart, the others as one


class TokenBucket:
    """Counts the rest of a `Rate`: filled all the time, emptied by events."""

    def __init__(self, rate: Rate, now: Callable[[], float] = time.monotonic) -> None:
        self._rate, self._now = rate, now
        self._left, self._at = rate.burst, now()

    def take(self) -> bool:
        """Take one if there is one."""
        self._fill()
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True

    def wait(self, count: float = 1.0) -> float:
        """Take so many in any case, and return the seconds until there are as many."""
        self._fill()
        self._left -= count
        return max(0.0, -self._left / self._rate.per_second)

    def _fill(self) -> None:
        now = self._now()
        self._left = min(self._rate.burst, self._left + (now - self._at) * self._rate.per_second)
        self._at = now


class PeerRates:
    """One bucket for all, and one for each of the peers that were seen last."""

    def __init__(
        self, each: Rate, peers: int, now: Callable[[], float], in_all: Rate | None = None
    ) -> None:
        self._each, self._peers, self._now = each, peers, now
        self._all = None if in_all is None else TokenBucket(in_all, now)
        self._of: OrderedDict[str, TokenBucket] = OrderedDict()

    def take(self, peer: str) -> bool:
        """Take one of a peer's, if there is one."""
        bucket = self._of.pop(peer, None) or TokenBucket(self._each, self._now)
        self._of[peer] = bucket
        while len(self._of) > self._peers:
            self._of.popitem(last=False)
        return bucket.take() and (self._all is None or self._all.take())
