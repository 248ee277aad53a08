"""Before it is announced, a server is asked for what it must refuse, over a real socket.

The guard leans on private parts of viser and on websockets. Should another version of them pass it
by, then nothing is served.
"""

from __future__ import annotations

import http.client
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from llsrbm.errors import Error

_PATIENCE = 10.0  # s for an answer; the server has nothing else to do yet
_FOREIGN = "guard-check.invalid"  # a name that nobody can have
_KEY = "Z3VhcmQgY2hlY2sgb25seQ=="  # of a WebSocket: any 16 bytes


class GuardMissing(Error):
    """The server lets in what its guard refuses; it must not be served."""


@dataclass(frozen=True)
class Trial:
    """A request and the status it has to be refused with."""

    what: str
    headers: Mapping[str, str]
    status: int


def check(host: str, port: int, *, token: bool) -> None:
    """Ask a server for what it must refuse.

    Args:
        host: address that it is bound to.
        port: its port.
        token: whether nobody may enter without one.

    Raises:
        GuardMissing: it let something in, or does not answer.
    """
    address = {"0.0.0.0": "127.0.0.1", "::": "::1", "": "127.0.0.1"}.get(host, host)  # noqa: S104
    for trial in _trials(port, token=token):
        try:
            status, headers = _asked(address, port, trial.headers)
        except (OSError, http.client.HTTPException, ValueError) as error:
            raise GuardMissing(
                f"the server does not answer to its own check ({type(error).__name__}); not served"
            ) from error
        if status != trial.status or "Content-Security-Policy" not in headers:
            raise GuardMissing(
                f"the guard did not take hold: {trial.what} was answered with {status} instead of "
                f"{trial.status}; not served (is viser the version that is pinned?)"
            )


def _trials(port: int, *, token: bool) -> Iterator[Trial]:
    own = f"127.0.0.1:{port}"
    upgrade = {
        "Connection": "Upgrade",
        "Upgrade": "websocket",
        "Sec-WebSocket-Version": "13",
        "Sec-WebSocket-Key": _KEY,
    }
    yield Trial("a request under another name", {"Host": _FOREIGN}, 403)
    yield Trial(
        "a WebSocket of another site",
        {"Host": own, "Origin": f"http://{_FOREIGN}", **upgrade},
        403,
    )
    if token:
        yield Trial("a request without the token", {"Host": own}, 401)
        yield Trial(
            "a WebSocket without the token",
            {"Host": own, "Origin": f"http://{own}", **upgrade},
            401,
        )


def _asked(
    address: str, port: int, headers: Mapping[str, str]
) -> tuple[int, http.client.HTTPMessage]:
    connection = http.client.HTTPConnection(address, port, timeout=_PATIENCE)
    try:
        connection.putrequest("GET", "/", skip_host=True, skip_accept_encoding=True)
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        return answer.status, answer.headers
    finally:
        connection.close()
