"""Before it is announced, a server is sent requests that it must refuse, over a real socket.

The guard leans on private parts of viser and on websockets. Should another version of them pass it
by, then nothing is served.
"""

import http.client
from collections.abc import Mapping

from llsrbm.errors import Error

_TIMEOUT = 10.0  # s for an answer; the server has nothing else to do yet
_FOREIGN = "guard-check.invalid"  # a name that nobody can have
_UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "Z3VhcmQgY2hlY2sgb25seQ==",  # any 16 bytes
}


class GuardMissing(Error):
    """The server lets in requests that its guard refuses; it must not be served."""


def check(host: str, port: int, *, token: bool) -> None:
    """Send a server the requests that it must refuse; a `token`: nobody may enter without it.
    Raises `GuardMissing`: it let something in, or does not answer.
    """
    address = {"0.0.0.0": "127.0.0.1", "::": "::1", "": "127.0.0.1"}.get(host, host)  # noqa: S104
    own = f"127.0.0.1:{port}"
    foreign_site = {"Host": own, "Origin": f"http://{_FOREIGN}", **_UPGRADE}
    own_site = {"Host": own, "Origin": f"http://{own}", **_UPGRADE}
    trials: list[tuple[str, Mapping[str, str], int]] = [
        ("a request under another name", {"Host": _FOREIGN}, 403),
        ("a WebSocket of another site", foreign_site, 403),
    ]
    if token:
        trials.append(("a request without the token", {"Host": own}, 401))
        trials.append(("a WebSocket without the token", own_site, 401))
    for name, sent, expected in trials:
        try:
            status, headers = _request(address, port, sent)
        except (OSError, http.client.HTTPException, ValueError) as error:
            raise GuardMissing(
                f"the server does not answer to its own check ({type(error).__name__}); not served"
            ) from error
        if status != expected or "Content-Security-Policy" not in headers:
            raise GuardMissing(
                f"the guard did not take hold: {name} was answered with {status} instead of "
                f"{expected}; not served (is viser the version that is pinned?)"
            )


def _request(
    address: str, port: int, headers: Mapping[str, str]
) -> tuple[int, http.client.HTTPMessage]:
    connection = http.client.HTTPConnection(address, port, timeout=_TIMEOUT)
    try:
        connection.putrequest("GET", "/", skip_host=True, skip_accept_encoding=True)
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        return answer.status, answer.headers
    finally:
        connection.close()
