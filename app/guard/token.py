"""The token that opens the page, and the cookie that stands for it afterwards."""

from __future__ import annotations

import hashlib
import hmac
import re
import secrets
import time
from collections.abc import Callable, Iterable

from llsrbm.errors import InputError

NONE = "none"  # Given instead of a token: anybody may enter

COOKIE_LIFE = 7 * 24 * 3600  # s until the address with the token has to be opened again

_TOKEN = re.compile(r"[A-Za-z0-9_-]{16,256}")  # goes into an address as it is; 96 bits and more
_BYTES = 32  # of a generated token
_VALUE = re.compile(r"([0-9]{1,12})\.([0-9a-f]{64})")
_MAX_COOKIES = 4  # of our name; browsers send one


class Access:
    """The token, if one is needed, and the cookies made from it.

    A cookie is an expiry and a code that only holders of the token can make. It is bound to the
    cookie's name and to the host it was given to; a server with another token does not accept it.
    """

    def __init__(
        self, token: str | None, port: int = 0, now: Callable[[], float] = time.time
    ) -> None:
        """Raise `InputError` of a token too short or not fit for an address."""
        if token is not None and not _TOKEN.fullmatch(token):
            raise InputError(
                "--token: expected 16 to 256 letters, digits, '-' or '_', or 'none' "
                f"for no token at all; got {len(token)} characters"
            )
        self.token = token  # at least 16 URL-safe characters; None: none is needed
        # part of the cookie's name: browsers keep those of all ports of a host together
        self.port = port
        self._now = now

    @classmethod
    def chosen(cls, token: str | None) -> Access:
        """Access by a given token, by none ("none"), or by a generated one (None)."""
        if token == NONE:
            return cls(None)
        return cls(secrets.token_urlsafe(_BYTES) if token is None else token)

    @property
    def required(self) -> bool:
        """True if nobody enters without the token."""
        return self.token is not None

    @property
    def query(self) -> str:
        """The part that follows the page's address."""
        return "" if self.token is None else f"/?token={self.token}"

    def accepts_token(self, token: str) -> bool:
        """Compare in a time that does not depend on where they differ."""
        return self.token is not None and hmac.compare_digest(_bytes(token), _bytes(self.token))

    def cookie(self, host: str, *, secure: bool = False) -> str:
        """A new cookie as a Set-Cookie header; `secure`: the browser came by TLS."""
        expiry = int(self._now()) + COOKIE_LIFE
        return (
            f"{self._name}={expiry}.{self._code(expiry, host)}; Max-Age={COOKIE_LIFE}; Path=/; "
            f"HttpOnly; SameSite=Strict{'; Secure' if secure else ''}"
        )

    def accepts_cookie(self, headers: Iterable[str], host: str) -> bool:
        """True if one of the Cookie headers of a request to `host` has a valid cookie."""
        if self.token is None:
            return False
        pairs = (pair.strip().partition("=") for header in headers for pair in header.split(";"))
        values = [value for name, _, value in pairs if name == self._name]
        return any(self._is_valid(value, host) for value in values[:_MAX_COOKIES])

    @property
    def _name(self) -> str:
        return f"llsrbm-{self.port}"

    def _is_valid(self, value: str, host: str) -> bool:
        found = _VALUE.fullmatch(value)
        if found is None:
            return False
        expiry = int(found[1])
        right = hmac.compare_digest(found[2].encode(), self._code(expiry, host).encode())
        return right and self._now() < expiry

    def _code(self, expiry: int, host: str) -> str:
        message = f"{self._name}\n{host}\n{expiry}"
        return hmac.new(_bytes(self.token or ""), _bytes(message), hashlib.sha256).hexdigest()


def _bytes(text: str) -> bytes:
    return text.encode("utf-8", "backslashreplace")
