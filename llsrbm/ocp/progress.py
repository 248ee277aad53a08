"""Progress and cancellation of a running solve.

A solver reports its iterations only by printing a table, whose last line is the progress: a thread
solves, while the caller's thread waits, looks now and then, and calls back.

One solve runs at a time in a process: Fatrop's print level is one for all, and a solver keeps the
statistics of its last solve alone. Expressions may be built meanwhile: CasADi's wheels count
references atomically (`CASADI_WITH_THREADSAFE_SYMBOLICS`). A cancelled solve ends at its next step
where Fatrop is patched (`llsrbm.ocp.fatrop_patches`), else when the solver is done with it; a
solver that is being built, at the next stage (`llsrbm.abandon`). The next solve waits for that, the
end of the process does not.
"""

import atexit
import itertools
import re
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from typing import Any, TextIO, TypeVar, cast

from llsrbm.abandon import ended_by
from llsrbm.errors import Cancelled
from llsrbm.ocp import fatrop_patches

POLL_INTERVAL = 0.02  # s between questions whether to go on: a tenth of what a person notices
REPORT_INTERVAL = 0.1  # s between reports of one solve
EXIT_WITHIN = 0.5  # s that the end of the process waits for a cancelled solve

# A row of Fatrop's or Ipopt's table: iteration, objective, constraint violation, ...
_ROW = re.compile(r"^ *(\d+)r? +[-+.\deE]+ +([-+.\deE]+) ")

solving = threading.RLock()  # held while a solver runs or is made
_numbers = itertools.count(1)
_exiting, _parked = threading.Event(), threading.Event()

Result = TypeVar("Result")


def when_idle(cancelled: Callable[[], bool] | None = None) -> None:
    """Wait for the end of a solve whose caller has gone; `Cancelled` once `cancelled()` is true."""
    while not solving.acquire(timeout=POLL_INTERVAL):
        if cancelled is not None and cancelled():
            raise _cancelled()
    solving.release()


class IterationTable:
    """The last row of the table that a solver prints: `last`, iteration and residual, or None."""

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
    sys.stdout = cast("TextIO", tap)
    try:
        yield
    finally:
        tap.thread = None  # from now on everything is passed on
        # Code that redirected the output meanwhile restores it itself.
        if cast("object", sys.stdout) is tap:
            sys.stdout = tap.beyond


class _Tap:
    def __init__(self, beyond: TextIO, read: Callable[[str], None]) -> None:
        self.beyond, self._read = beyond, read
        self.thread: int | None = threading.get_ident()

    def write(self, text: str) -> int:
        if threading.get_ident() != self.thread:
            return self.beyond.write(text)
        if _exiting.is_set():
            _parked.set()
            threading.Event().wait()
        self._read(text)
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.beyond, name)


@atexit.register
def _exit() -> None:
    """Stop a cancelled solve before the interpreter ends.

    A thread that returns from the solver, or prints, into an interpreter that ends would abort the
    process: one that prints is kept where it does.
    """
    _exiting.set()
    until = time.monotonic() + EXIT_WITHIN
    while time.monotonic() < until and not _parked.is_set():
        if solving.acquire(timeout=POLL_INTERVAL):
            break


def attended(
    solve: Callable[[], Result],
    latest: Callable[[], tuple[int, float] | None],
    report: Callable[[int, float], None] | None,
    cancelled: Callable[[], bool] | None,
) -> Result:
    """Run `solve` in a thread of its own; meanwhile call back from the caller's thread.

    Args:
        solve: it runs when no other solve does, and not at all once it has been cancelled.
        latest: the newest iteration and residual.
        report: called with them when they change, at most every `REPORT_INTERVAL`.
        cancelled: polled; true to return at once with `Cancelled`, whatever the solver does.
    """
    number, abandoned = next(_numbers), threading.Event()
    future: Future[Result] = Future()

    def run() -> None:
        try:
            with solving, ended_by(abandoned):
                if abandoned.is_set():
                    raise _cancelled()
                fatrop_patches.begin(number)
                try:
                    result = solve()
                finally:
                    fatrop_patches.begin(0)
            future.set_result(result)
        except BaseException as error:  # noqa: BLE001 - for the caller's thread
            future.set_exception(error)

    if report is None and cancelled is None:
        run()
        return future.result()
    # A daemon: the process may end while the solver runs.
    threading.Thread(target=run, name="solve", daemon=True).start()
    reported, due = None, time.monotonic() + REPORT_INTERVAL
    try:
        while True:
            try:
                return future.result(timeout=POLL_INTERVAL)
            except TimeoutError:
                if future.done():
                    raise
            if cancelled is not None and cancelled():
                raise _cancelled()
            progress = latest()
            if report and progress and progress != reported and time.monotonic() >= due:
                reported, due = progress, time.monotonic() + REPORT_INTERVAL
                report(*progress)
    finally:
        if not future.done():
            abandoned.set()
            fatrop_patches.cancel(number)


def interruptible(
    make: Callable[[], Result], cancelled: Callable[[], bool] | None = None
) -> Result:
    """Build something; raises `Cancelled` at once where `cancelled()` becomes true meanwhile."""
    return make() if cancelled is None else attended(make, lambda: None, None, cancelled)


def _cancelled() -> Cancelled:
    return Cancelled("planning was cancelled")
