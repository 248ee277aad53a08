"""The record of what was refused: every kind and peer once, then one summary a minute at most."""

import contextlib
import logging
from collections import Counter
from collections.abc import Callable, Iterator

from app.guard.limits import Limits, Rate, TokenBucket

_log = logging.getLogger(__name__)

_LONGEST_DETAIL = 120  # characters
_IN_A_SUMMARY = 5  # kinds that are named

_OTHERS = ("others", "various reasons")


class Refusals:
    """Counts refusals, in memory that does not grow with them."""

    def __init__(self, limits: Limits, now: Callable[[], float]) -> None:
        self._limits, self._now = limits, now
        self._muted = False
        self.forget()

    @contextlib.contextmanager
    def unlogged(self) -> Iterator[None]:
        """While it lasts nothing is noted down: the server tries its own guard."""
        self._muted = True
        try:
            yield
        finally:
            self._muted = False

    def note(self, peer: str, reason: str, detail: str = "") -> bool:
        """Count a refusal; true if it is the first of its kind, which is a line of the log."""
        if self._muted:
            return False
        key = (peer, reason)
        first = key not in self._known
        if first:
            if len(self._known) >= self._limits.refusals:
                self._known.clear()
            self._known.add(key)
        if first and self._lines.take():
            shown = ascii(detail)[1:-1][:_LONGEST_DETAIL]
            _log.warning("refused %s: %s%s", peer, reason, f" ({shown})" if detail else "")
        else:
            full = len(self._since) >= self._limits.refusals and key not in self._since
            self._since[_OTHERS if full else key] += 1
        if self._now() >= self._summary_due:
            self.summarise()
        return first

    def summarise(self) -> None:
        """One line about what was refused since the last one, if anything was."""
        self._summary_due = self._now() + self._limits.summary_s
        if not self._since:
            return
        named = self._since.most_common(_IN_A_SUMMARY)
        rest = self._since.total() - sum(count for _, count in named)
        parts = [f"{count} x {peer}: {reason}" for (peer, reason), count in named]
        if rest:
            parts.append(f"{rest} x others")
        _log.warning("refused %d more since: %s", self._since.total(), "; ".join(parts))
        self._since.clear()

    def forget(self) -> None:
        """Begin anew."""
        self._known: set[tuple[str, str]] = set()
        self._since: Counter[tuple[str, str]] = Counter()  # the last summary
        self._summary_due = self._now() + self._limits.summary_s
        lines = self._limits.first_lines
        self._lines = TokenBucket(Rate(lines / 60.0, lines), self._now)
