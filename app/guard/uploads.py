"""Room for files that tabs are sending: bounded, and not to be held by those that send nothing."""

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from app.guard.limits import Limits


@dataclass
class _Upload:
    peer: str
    since: float  # s, of its last part
    held: int = 0  # bytes


class Uploads:
    """Unfinished files of all tabs, one a tab; on the server's event loop alone.

    Only bytes that have come count. Where they are too many, the peer that has most of them loses
    the file that waits longest for its next part.
    """

    def __init__(self, limits: Limits, now: Callable[[], float] = time.monotonic) -> None:
        self._limits, self._now = limits, now
        self._of: dict[int, _Upload] = {}  # tab -> its file

    def begin(self, tab: int, peer: str) -> None:
        """A tab sends a file, in place of one that it has begun before."""
        self._of[tab] = _Upload(peer, self._now())

    def end(self, tab: int) -> None:
        """A tab's file is complete, or the tab is gone."""
        self._of.pop(tab, None)

    def part(self, tab: int, size: int) -> list[int]:
        """Count so many bytes of a tab's file; the tabs whose files have to be dropped."""
        upload = self._of.get(tab)
        if upload is not None:
            upload.held += size
            upload.since = self._now()
        dropped = self.idle()
        while sum(each.held for each in self._of.values()) > self._limits.upload_bytes:
            of_peers: Counter[str] = Counter()
            for each in self._of.values():
                of_peers[each.peer] += each.held
            (most, _), *_ = of_peers.most_common(1)
            victim = min(
                (each for each in self._of if self._of[each].peer == most),
                key=lambda each: self._of[each].since,
            )
            self.end(victim)
            dropped.append(victim)
        return dropped

    def idle(self) -> list[int]:
        """Forget files whose next part is overdue; their tabs."""
        before = self._now() - self._limits.upload_idle_s
        late = [tab for tab, upload in self._of.items() if upload.since < before]
        for tab in late:
            self.end(tab)
        return late
