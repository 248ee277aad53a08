"""Calls made in order by a thread of their own, so that no caller waits for a slow listener."""

import logging
import queue
import threading
import time
from collections.abc import Callable

# A listener has to return at once, s: it delays all that come after it, and the log says so.
SLOW = 1.0

_log = logging.getLogger(__name__)

Call = Callable[[], object]


class Deliveries:
    """Makes calls one after the other, in the order in which they were put."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._calls: queue.SimpleQueue[Call | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def put(self, call: Call) -> None:
        """Have it called soon; from any thread, never waits."""
        self._calls.put(call)

    def close(self, patience: float) -> None:
        """Make the calls that were put, within `patience`, s, and end; later ones are dropped."""
        self._calls.put(None)
        if threading.current_thread() is not self._thread:
            self._thread.join(patience)

    def _run(self) -> None:
        while (call := self._calls.get()) is not None:
            began = time.monotonic()
            try:
                call()
            except Exception:  # noqa: BLE001  # a defect of one listener must not reach the others
                _log.exception("%s: a listener failed", self._name)
            took = time.monotonic() - began
            if took > SLOW:
                _log.warning("%s: a listener took %.1f s", self._name, took)
