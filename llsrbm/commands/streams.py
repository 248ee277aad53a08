"""Standard streams of a command that survive whatever a shell makes of them.

A stream may be closed (`>&-`), its disk full, its reader gone (`| head -1`), and an encoding may
lack letters.
"""

import contextlib
import io
import os
import sys
from collections.abc import Iterator
from typing import Any, TextIO


class OutputLost(Exception):  # no error where the reader has simply gone
    """The standard output takes no more; `reason`: why, "" where its reader has gone."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason


class _Raw(io.FileIO):
    """A stream's bytes; after the first failure the rest is dropped.

    `strict`: whether that failure is raised, as `OutputLost`.
    """

    def __init__(self, number: int, *, strict: bool, closefd: bool) -> None:
        super().__init__(number, "w", closefd=closefd)
        self._strict, self._lost = strict, False

    def write(self, content: Any) -> int:
        """Write bytes; raises `OutputLost` once, where the stream is strict."""
        if self._lost:
            return len(content)
        try:
            return super().write(content)
        except OSError as error:
            self._lost = True
            if self._strict:
                gone = isinstance(error, BrokenPipeError)
                raise OutputLost("" if gone else error.strerror or str(error)) from error
            return len(content)


def text_stream(number: int, *, strict: bool = True, closefd: bool = False) -> TextIO:
    """A text stream to a file descriptor; letters that its encoding lacks are escaped."""
    raw = _Raw(number, strict=strict, closefd=closefd)
    kept = (sys.__stdout__ if strict else sys.__stderr__) or None
    return io.TextIOWrapper(
        io.BufferedWriter(raw),
        encoding=kept.encoding if kept else "utf-8",
        errors="backslashreplace",
        line_buffering=not strict or raw.isatty(),
    )


@contextlib.contextmanager
def usable_streams() -> Iterator[None]:
    """Within the block the process's own standard streams are such streams, closed ones too.

    Streams that something else has put in their place, a test say, stay as they are.
    """
    kept = sys.stdout, sys.stderr
    # A closed number would be the next file's, which then got what is printed.
    for number, flags in ((0, os.O_RDONLY), (1, os.O_RDONLY), (2, os.O_WRONLY)):
        _fill(number, flags)  # nothing can be written to 1: it says so as a full disk does
    if sys.stdout is sys.__stdout__:
        sys.stdout = text_stream(1)
    if sys.stderr is sys.__stderr__:
        sys.stderr = text_stream(2, strict=False)
    try:
        yield
    finally:
        with contextlib.suppress(OutputLost):
            sys.stdout.flush()
        sys.stdout, sys.stderr = kept


def _fill(number: int, flags: int) -> None:
    """Open the null device in place of a closed standard stream."""
    try:
        os.fstat(number)
    except OSError:
        opened = os.open(os.devnull, flags)
        if opened == number:
            os.set_inheritable(number, True)
        else:
            os.dup2(opened, number)
            os.close(opened)
