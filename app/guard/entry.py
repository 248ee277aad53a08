"""Between viser's server and who guards it: what is requested, and what is decided about it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from http import HTTPStatus
from typing import Protocol

from app.guard.limits import Limits


@dataclass(frozen=True)
class Request:
    """The head of an HTTP request.

    Attributes:
        method: GET, HEAD, ...
        target: path and query as they were sent.
        headers: name in lower case -> every value that came under it.
        peer: address of the other side.
    """

    method: str
    target: str
    headers: Mapping[str, tuple[str, ...]]
    peer: str

    @classmethod
    def of(cls, method: str, target: str, headers: Iterable[tuple[str, str]], peer: str) -> Request:
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
        """Whether it wants to become a WebSocket."""
        wanted = ",".join(self.values("upgrade")).lower().split(",")
        return "websocket" in (name.strip() for name in wanted)


@dataclass(frozen=True)
class Decision:
    """The answer to a request.

    Attributes:
        status: 101 lets it in as a WebSocket, 200 with the page; all others are answered with
            `body`.
        reason: the kind of refusal, in words of our own; empty if there is none.
        body: of the answer, unless it is the page or the WebSocket.
        html: whether `body` is, instead of plain text.
        headers: of this answer, besides those of all.
    """

    status: HTTPStatus
    reason: str = ""
    body: str = ""
    html: bool = False
    headers: tuple[tuple[str, str], ...] = ()


class Gate(Protocol):
    """Decides who is let in, and keeps the record of those who are not.

    All of it is called on the server's event loop.
    """

    limits: Limits

    def decide(self, request: Request, tabs: int) -> Decision:
        """Decide about a request.

        Args:
            request: its head.
            tabs: that are open, or were let in and are about to be.
        """
        ...

    def headers(self, host: str) -> tuple[tuple[str, str], ...]:
        """Those of every answer.

        Args:
            host: the request's, if it is a known one, else empty.
        """
        ...

    def note(self, peer: str, reason: str, detail: str = "") -> bool:
        """Note down that something was refused; true if it is the first of its kind.

        Args:
            peer: address of the other side.
            reason: a kind, not made of what the peer sent.
            detail: may be made of it.
        """
        ...
