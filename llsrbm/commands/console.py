"""Output of commands: results on stdout, errors and progress on stderr, exit statuses."""

from __future__ import annotations

import contextlib
import json
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any, TextIO

from llsrbm.commands.streams import text_stream

if TYPE_CHECKING:
    from llsrbm.planning.solve.watch import PlanningProgress

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130  # exit statuses
_LINE_TIME = 30.0  # s between lines of progress where there is no terminal
_WIDTH = 24  # characters of a bar


def print_error(message: str) -> None:
    """Print an error in one line on stderr, without control codes from a file or a name."""
    line = "".join(letter for letter in " ".join(message.split()) if letter.isprintable())
    print(f"llsrbm: {line}", file=sys.stderr)


def show_planning(message: str | PlanningProgress) -> None:
    """Show a plan's progress on a terminal; a script's stderr has errors alone."""
    if not sys.stderr.isatty():
        return
    if isinstance(message, str):
        print(message, file=sys.stderr)
    elif message.iteration is None:
        print(message.text, file=sys.stderr)
    else:  # on a line that the next one overwrites
        row = f"  iteration {message.iteration}, residual {message.residual:.1e} "
        print(row, end="\r", file=sys.stderr, flush=True)


def show_simulation(share: float) -> None:
    """Show the share of a simulation that is done, 0 to 1, on a terminal."""
    if sys.stderr.isatty():
        end = "\n" if share >= 1 else ""
        print(f"\rsimulating {100 * share:3.0f} %", end=end, file=sys.stderr, flush=True)


@contextlib.contextmanager
def counting(noun: str) -> Iterator[Callable[[int, int], None]]:
    """A function of (done, total) that shows progress: a bar, or now and then a line for a log.

    `noun` is the plural of what is counted.
    """
    from llsrbm.number_text import duration

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


def print_result(
    result: dict[str, Any], lines: dict[str, str], stdout: TextIO, *, as_json: bool
) -> None:
    """Print a result as one JSON object, or its `lines`."""
    if as_json:
        print(json.dumps(result, allow_nan=False), file=stdout)
    else:
        width = max(map(len, lines), default=0)
        for name, value in lines.items():
            print(f"{name:<{width}}  {value}", file=stdout)


def print_remarks(remarks: Iterable[str]) -> None:
    """Print what is not as one would expect, a line each, on stderr."""
    for remark in remarks:
        print_error(remark)


def print_table(rows: dict[str, str]) -> None:
    """Print names and their descriptions in two columns."""
    width = max(map(len, rows))
    for name, description in rows.items():
        print(f"{name:{width}}  {description}")


def result_stream(*, as_json: bool) -> AbstractContextManager[TextIO]:
    """Stream of a command's result; for JSON nothing else gets to stdout."""
    return _stdout_kept_for_result() if as_json else contextlib.nullcontext(sys.stdout)


@contextlib.contextmanager
def _stdout_kept_for_result() -> Iterator[TextIO]:
    """Send everything that is printed, compiled libraries' banners included, to stderr.

    Yields the real stdout.
    """
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        with (
            text_stream(os.dup(kept), closefd=True) as stdout,
            contextlib.redirect_stdout(sys.stderr),
        ):
            yield stdout
    finally:
        os.dup2(kept, 1)
        os.close(kept)
