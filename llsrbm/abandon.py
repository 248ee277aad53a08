"""Long computations whose caller may have gone: they go on step by step, and end between two."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from llsrbm.errors import Cancelled

_here = threading.local()


@contextmanager
def ended_by(abandoned: threading.Event) -> Iterator[None]:
    """Have `go_on`, called by this thread meanwhile, end the computation once the event is set."""
    _here.abandoned = abandoned
    try:
        yield
    finally:
        del _here.abandoned


def go_on() -> None:
    """Raise `Cancelled` if nobody waits any more for what this thread computes."""
    abandoned: threading.Event | None = getattr(_here, "abandoned", None)
    if abandoned is not None and abandoned.is_set():
        raise Cancelled("planning was cancelled")
