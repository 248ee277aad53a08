"""Requests as nobody's browser sends them."""

import http.client
import socket

UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "Z3VhcmQgY2hlY2sgb25seQ==",
}


class Answer:
    """Attributes: status; headers, without regard to case; body."""

    def __init__(self, status, headers, body):
        self.status, self.headers, self.body = status, headers, body

    @property
    def cookie(self):
        """What a browser sends back."""
        return self.headers["Set-Cookie"].partition(";")[0]


def asked(port, path="/", headers=(), method="GET", address="127.0.0.1", host=None):
    """The answer to a request; headers are pairs or a mapping, a Host is added."""
    pairs = list(headers.items() if isinstance(headers, dict) else headers)
    if not any(name == "Host" for name, _ in pairs):
        pairs.insert(0, ("Host", host or f"127.0.0.1:{port}"))
    connection = http.client.HTTPConnection(address, port, timeout=20)
    try:
        connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        for name, value in pairs:
            connection.putheader(name, value)
        connection.endheaders()
        response = connection.getresponse()
        body = b"" if response.status == 101 else response.read()
        return Answer(response.status, response.headers, body)
    finally:
        connection.close()


def sent(port, content, timeout=20):
    """All that comes back until the server closes."""
    with socket.create_connection(("127.0.0.1", port), timeout=timeout) as plain:
        plain.sendall(content)
        received = b""
        try:
            while part := plain.recv(1 << 16):
                received += part
        except ConnectionResetError:
            pass
    return received
