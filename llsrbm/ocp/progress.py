"""News of a solve while it runs, and a way out of it.

A solver reports its iterations only by printing a table. News are the table's last line: a thread
solves, the caller's thread waits, looks now and then, and calls back.

CasADi is not safe to use from two threads. A solve cannot be stopped, so one that was cancelled is
left to its end, and everything that uses CasADi afterwards waits for that (`when_idle`).
"""

from __future__ import annotations

import io
import re
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import TextIO, TypeVar

from llsrbm.errors import Cancelled

LOOK_EVERY = 0.02  # s between questions whether to go on: a tenth of what a person notices
TELL_EVERY = 0.1  # s between news of one solve

# A row of Fatrop's or Ipopt's table: iteration, objective, constraint violation, ...
_ROW = re.compile(r"^ *(\d+)r? +[-+.\deE]+ +([-+.\deE]+) ")

# CasADi counts references without locks: two solves at once would corrupt memory.
_solving = threading.Lock()

_CANCELLED = "planning was cancelled"

Result = TypeVar("Result")


def when_idle(cancelled: Callable[[], bool] | None = None) -> None:
    """Wait for the end of a solve that nobody waits for any more; then CasADi may be used.

    Args:
        cancelled: whether to go on waiting, asked every `LOOK_EVERY`.

    Raises:
        Cancelled: not to.
    """
    while not _solving.acquire(timeout=LOOK_EVERY):
        if cancelled is not None and cancelled():
            raise Cancelled(_CANCELLED)
    _solving.release()


class IterationTable:
    """The last row of the table that a solver prints.

    Attributes:
        last: iteration and residual; None before the first row.
    """

    def __init__(self) -> None:
        self.last: tuple[int, float] | None = None
        self._line = ""

    def read(self, text: str) -> None:
        """Take a piece of what is printed; pieces end anywhere."""
        *lines, self._line = (self._line + text).split("\n")
        for line in lines:
            if row := _ROW.match(line):
                self.last = int(row[1]), float(row[2])


@contextmanager
def printed_into(read: Callable[[str], None]) -> Iterator[None]:
    """Hand what this thread prints to `read`; other threads go on printing as before."""
    tap = _Tap(sys.stdout, read)
    sys.stdout = tap
    try:
        yield
    finally:
        tap.close_tap()
        # Code that redirected the output meanwhile restores it itself; the closed tap passes it on.
        if sys.stdout is tap:
            sys.stdout = tap.beyond


class _Tap(io.TextIOBase):
    """Stands in for `sys.stdout`."""

    def __init__(self, beyond: TextIO, read: Callable[[str], None]) -> None:
        self.beyond, self._read = beyond, read
        self._thread: int | None = threading.get_ident()

    def close_tap(self) -> None:
        """Pass everything on from now on."""
        self._thread = None

    def write(self, text: str) -> int:
        if threading.get_ident() == self._thread:
            self._read(text)
            return len(text)
        return self.beyond.write(text)

    def flush(self) -> None:
        self.beyond.flush()

    def isatty(self) -> bool:
        return self.beyond.isatty()

    def fileno(self) -> int:
        return self.beyond.fileno()


def attended(
    solve: Callable[[], Result],
    look: Callable[[], tuple[int, float] | None],
    tell: Callable[[int, float], None] | None,
    cancelled: Callable[[], bool] | None,
) -> Result:
    """What `solve` returns; meanwhile `tell` and `cancelled` are called, by the caller's thread.

    A solver cannot be stopped: when `cancelled` says so, this returns at once, and the solve runs
    on unseen to its end. The next one waits for it; anything else that uses CasADi has to, too
    (`when_idle`). A solve that had not begun never does.

    Args:
        solve: runs in a thread of its own, alone of its kind in the process.
        look: the newest iteration and residual.
        tell: is told of them, at most every `TELL_EVERY`.
        cancelled: whether the result is not wanted any more, asked every `LOOK_EVERY`.

    Raises:
        Cancelled: it was not.
    """
    abandoned = threading.Event()

    def alone() -> Result:
        with _solving:
            if abandoned.is_set():
                raise Cancelled(_CANCELLED)
            return solve()

    if tell is None and cancelled is None:
        return alone()
    executor = ThreadPoolExecutor(max_workers=1, thread_name_prefix="solve")
    future = executor.submit(alone)
    executor.shutdown(wait=False)
    told, told_at = None, time.monotonic()
    while True:
        try:
            return future.result(timeout=LOOK_EVERY)
        except TimeoutError:
            if cancelled is not None and cancelled():
                abandoned.set()
                raise Cancelled(_CANCELLED) from None
        news = look()
        due = time.monotonic() - told_at >= TELL_EVERY
        if tell is not None and news is not None and news != told and due:
            told, told_at = news, time.monotonic()
            tell(*news)
