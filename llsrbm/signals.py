"""An end that is asked for by a signal, in place of an exception anywhere."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

_REASONS = {signal.SIGINT: "Ctrl-C", signal.SIGTERM: "it was told to"}


@contextmanager
def stop_on_signal(on_stop: Callable[[str], object] = lambda _: None) -> Iterator[threading.Event]:
    """An event that SIGINT and SIGTERM set, `on_stop` told why; the former handlers come back.

    Set while something is still imported or built, it stops what comes of that.
    """
    stop = threading.Event()

    def handle(number: int, _frame: FrameType | None) -> None:
        stop.set()
        on_stop(_REASONS[signal.Signals(number)])

    former = {number: signal.signal(number, handle) for number in _REASONS}
    try:
        yield stop
    finally:
        for number, handler in former.items():
            signal.signal(number, handler)
