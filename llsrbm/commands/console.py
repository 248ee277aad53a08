"""Talking to whoever called: the result on stdout, the rest on stderr, a status at the end."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from llsrbm.planning.solve.progress import PlanningProgress

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130  # exit statuses


def complain(message: str) -> None:
    """Say in one line on stderr what is wrong."""
    print(f"llsrbm: {' '.join(message.split())}", file=sys.stderr)


def tell(message: str | PlanningProgress) -> None:
    """Tell a waiting person; a script's stderr is for what is wrong."""
    if not sys.stderr.isatty():
        return
    if isinstance(message, str):
        print(message, file=sys.stderr)
    elif message.iteration is None:
        print(message.text, file=sys.stderr)
    else:  # on a line that the next one overwrites
        row = f"  iteration {message.iteration}, residual {message.residual:.1e} "
        print(row, end="\r", file=sys.stderr, flush=True)


def tell_share(share: float) -> None:
    """Tell a waiting person how much of the simulation is done, 0 to 1, in one line."""
    if sys.stderr.isatty():
        end = "\n" if share >= 1 else ""
        print(f"\rsimulating {100 * share:3.0f} %", end=end, file=sys.stderr, flush=True)


def print_lines(lines: dict[str, str], stdout: TextIO) -> None:
    """Print a word and what there is to say about it, line by line."""
    for name, value in lines.items():
        print(f"{name:<10}{value}", file=stdout)


def result_stream(*, as_json: bool) -> AbstractContextManager[TextIO]:
    """Where a command prints its result; for JSON nothing else gets to stdout."""
    return _stdout_kept_for_result() if as_json else contextlib.nullcontext(sys.stdout)


@contextlib.contextmanager
def _stdout_kept_for_result() -> Iterator[TextIO]:
    """Send everything that is printed, compiled libraries' banners included, to stderr.

    Yields:
        The real stdout.
    """
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        with (
            os.fdopen(os.dup(kept), "w", encoding="utf-8") as stdout,
            contextlib.redirect_stdout(sys.stderr),
        ):
            yield stdout
    finally:
        os.dup2(kept, 1)
        os.close(kept)
