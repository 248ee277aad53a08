"""The entrance of the command line: light, so that Ctrl-C ends a command that still imports."""

from __future__ import annotations

import os
import signal
import sys

TYPE_CHECKING = False  # `typing` would take longer to import than all of the above
if TYPE_CHECKING:
    from collections.abc import Sequence

_INTERRUPTED = 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command line and return its exit status. `arguments`: without the program's name;
    default: the process's own, whose signals are handled too.
    """
    if arguments is not None or signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        from llsrbm.commands.program import run

        return run(None if arguments is None else list(arguments))
    # An exception in the middle of an import is a traceback, or is swallowed by a library.
    signal.signal(signal.SIGINT, lambda *_: os._exit(_INTERRUPTED))
    from llsrbm.commands.program import run

    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        return run(None)
    except KeyboardInterrupt:
        return _INTERRUPTED
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the interpreter ends


if __name__ == "__main__":
    sys.exit(main())
