"""Notes over the picture: they stay until they are closed, and no two are alike."""

from __future__ import annotations

import viser

MOST = 4
"""That stand at a time; more would cover the picture."""


class Notes:
    """One tab's; for the session's thread."""

    def __init__(self, client: viser.ClientHandle) -> None:
        """No note yet."""
        self._client = client
        self._shown: dict[tuple[str, str], viser.NotificationHandle] = {}  # the oldest first

    def show(self, title: str, body: str) -> None:
        """Add a note, in place of the one that says the same."""
        while len(self._shown) >= MOST or (title, body) in self._shown:
            alike = (title, body)
            oldest = alike if alike in self._shown else next(iter(self._shown))
            self._shown.pop(oldest).remove()
        self._shown[title, body] = self._client.add_notification(title, body, color="orange")
