"""How many frames a second a tab can take.

A browser that is sent more than it can draw falls behind, and then answers a slider late. So the
tab is asked something now and then while it plays, and the rate follows the time until it answers.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

FASTEST, SLOWEST, FIRST = 60.0, 12.0, 30.0
"""Frames/s."""

_INTERVAL = 0.25  # s between questions
_BEHIND = 0.1  # s; a browser that answers later has work waiting
_AT_EASE = 0.05  # s; network and one frame of 60 Hz each way stay below this


class Pace:
    """The frame rate of one tab, kept up to date by a thread of its own."""

    def __init__(
        self,
        ask: Callable[[], object],
        playing: Callable[[], bool],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Nothing is asked before `start`.

        Args:
            ask: returns when the browser has answered; raises `TimeoutError` if it does not,
                `RuntimeError` if it has gone.
            playing: whether frames are being sent.
            clock: s.
        """
        self._ask = ask
        self._playing = playing
        self._clock = clock
        self._rate = FIRST
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name="pace", daemon=True)

    def start(self) -> None:
        """Begin to ask."""
        self._thread.start()

    def close(self) -> None:
        """Stop asking; does not wait for the last answer."""
        self._closed.set()

    def rate(self) -> float:
        """Frames/s to send at present."""
        return self._rate

    def learn(self, delay: float) -> None:
        """Take note of how long an answer took, s: late ones tell at once, quick ones slowly."""
        if delay > _BEHIND:
            self._rate = max(SLOWEST, 0.75 * self._rate)
        elif delay < _AT_EASE:
            self._rate = min(FASTEST, 1.15 * self._rate)

    def _run(self) -> None:
        while not self._closed.wait(_INTERVAL):
            if not self._playing():
                continue
            asked = self._clock()
            try:
                self._ask()
            except TimeoutError:
                pass
            except RuntimeError:
                # Gone, or a browser that forbids storage: the answer was none, but it came in time.
                if self._closed.wait(_INTERVAL):
                    return
            self.learn(self._clock() - asked)
