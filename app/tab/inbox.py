"""Everything that waits for a session's thread, each reading of controls once."""

from __future__ import annotations

import queue
import time
from enum import Enum

from app.link import PageEvent, PageReady
from app.panel.actions import Action
from app.picture.landing_handle import Grip
from app.picture.push_handle import PushGrip
from app.tab.controls import READ_ACTIONS
from app.tab.events import Event


class End(Enum):
    """The session shall end."""

    END = 0


Item = Event | Action | Grip | PushGrip | PageEvent | tuple[str, bytes] | End
"""Events, and what becomes one when it is taken out; a name and content are a file."""


class Inbox:
    """`put` may be called from any thread, the rest by the session's."""

    def __init__(self) -> None:
        """Empty."""
        self._queue: queue.SimpleQueue[Item] = queue.SimpleQueue()
        self._held: list[Item] = []  # what came while the page was waited for
        self._due: tuple[float, Event] | None = None  # s (monotonic clock), what happens then

    def put(self, item: Item) -> None:
        """Add something; returns at once."""
        self._queue.put(item)

    def put_later(self, seconds: float, event: Event) -> None:
        """Have an event happen later, in place of the one that was to happen later before."""
        self._due = time.monotonic() + seconds, event

    @property
    def ended(self) -> bool:
        """Whether the session's end came while the page was waited for."""
        return End.END in self._held

    def wait_for_page(self, seconds: float) -> PageReady | None:
        """The page's greeting; None if none comes in time. What else comes is held back."""
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

    def take(self) -> list[Item]:
        """Everything that has happened; waits until something has, or is due."""
        items, self._held = self._held, []
        if not items:
            wait = None if self._due is None else max(0.0, self._due[0] - time.monotonic())
            try:
                items = [self._queue.get(timeout=wait)]
            except queue.Empty:
                assert self._due is not None
                (_, event), self._due = self._due, None
                return [event]
        while True:
            try:
                item = self._queue.get_nowait()
            except queue.Empty:
                return items
            # The latest of its kind counts; every press of a button does.
            if isinstance(item, Action) and item in READ_ACTIONS and item in items:
                items.remove(item)
            elif _outdated(items[-1], item):
                items.pop()
            items.append(item)


def _outdated(before: Item, after: Item) -> bool:
    """Whether a handle has been moved on; that it was let go of counts, whatever comes next."""
    match before, after:
        case Grip(), Grip():
            return True
        case PushGrip(ended=ended), PushGrip():
            return not ended
    return False
