"""Everything that waits for a session's thread, in order."""

import contextlib
import queue
import time
from enum import Enum
from typing import Any

from app.link import ApexDragged, PageReady, PhasesDragged, PushDragged
from app.panel.acts import Act, Button
from app.picture.foothold_handles import FootholdMoved
from app.picture.landing_handles import HandleMoved


class End(Enum):
    """The session shall end."""

    END = 0


class Inbox:
    """Events, and acts that become one when they are taken; any thread may `put`."""

    def __init__(self) -> None:
        self._queue: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._held: list[Any] = []  # what came while the page was waited for
        self._due: dict[type, tuple[float, Any]] = {}  # kind -> s (monotonic clock), event

    def put(self, item: Any) -> None:
        """Add something; returns at once."""
        self._queue.put(item)

    def put_later(self, seconds: float, event: Any) -> None:
        """Have an event happen later, in place of the one of its kind that was to happen later."""
        self._due[type(event)] = time.monotonic() + seconds, event

    @property
    def ended(self) -> bool:
        """Whether the session's end came while the page was waited for."""
        return End.END in self._held

    def wait_for_page(self, seconds: float) -> PageReady | None:
        """The page's greeting; None if none comes in time. Other events are held back."""
        until = time.monotonic() + seconds
        while True:
            try:
                item = self._queue.get(timeout=max(0.0, until - time.monotonic()))
            except queue.Empty:
                return None
            if isinstance(item, PageReady):
                return item
            self._held.append(item)
            if item is End.END:
                return None

    def take(self) -> list[Any]:
        """Everything that has happened; waits until something has, or is due."""
        items, self._held = self._held, []
        if not items:
            first = min((at for at, _ in self._due.values()), default=None)
            wait = None if first is None else max(0.0, first - time.monotonic())
            with contextlib.suppress(queue.Empty):
                items.append(self._queue.get(timeout=wait))
        while True:
            try:
                item = self._queue.get_nowait()
            except queue.Empty:
                break
            if items and _outdated(items[-1], item):
                items.pop()
            items.append(item)
        return items + self._due_by_now()

    def _due_by_now(self) -> list[Any]:
        now = time.monotonic()
        kinds = [kind for kind, (at, _) in self._due.items() if at <= now]
        return [self._due.pop(kind)[1] for kind in kinds]


def _outdated(before: Any, after: Any) -> bool:
    """Whether the latest of its kind counts: not over something else that happened between."""
    match before, after:
        case Act(), Act():  # controls are read as they stand when the act is taken
            return before is after and not isinstance(before.value, Button)
        case HandleMoved(landing=landing, begins=begins), HandleMoved(landing=other):
            return landing == other and not begins and before.held
        case FootholdMoved(foot=foot, begins=begins), FootholdMoved(foot=other):
            return foot == other and not begins and before.held
        case PushDragged(ended=ended), PushDragged():
            return not ended
        case (PhasesDragged(), PhasesDragged(begins=begins)) | (
            ApexDragged(),
            ApexDragged(begins=begins),
        ):
            return not begins and not before.begins
    return False
