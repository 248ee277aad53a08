"""Progress of something that takes minutes: a line that moves, or now and then one for a log."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from llsrbm.request.messages import duration

_LINE_TIME = 30.0  # s between lines where there is no terminal
_WIDTH = 24  # characters of the bar


@contextmanager
def counting(noun: str) -> Iterator[Callable[[int, int], None]]:
    """A function of the number that is done and of the total, which shows both.

    Args:
        noun: plural of the things that are counted.
    """
    terminal = sys.stderr.isatty()
    start = last = time.monotonic()
    first: int | None = None

    def show(done: int, total: int) -> None:
        nonlocal first, last
        now = time.monotonic()
        first = done if first is None else first
        if not terminal and now - last < _LINE_TIME:
            return
        last = now
        line = f"{done} of {total} {noun}"
        if done > first:
            rate = (done - first) / max(now - start, 1e-3)
            line += f", {rate:.1f} a second, {duration((total - done) / rate)} left"
        if terminal:
            full = _WIDTH * done // max(total, 1)
            line = f"\r\x1b[K{'━' * full}{'╌' * (_WIDTH - full)} {line}"
        print(line, file=sys.stderr, end="" if terminal else "\n", flush=True)

    try:
        yield show
    finally:
        if terminal and first is not None:
            print(file=sys.stderr)
