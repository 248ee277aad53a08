"""Locks of open files between processes; the system releases them when a process ends.

Linux and macOS have them by `fcntl`, Windows by `msvcrt`, where a shared lock is an exclusive one.
"""

from __future__ import annotations

import sys
from typing import IO, Any

from llsrbm.errors import Error

if sys.platform == "win32":
    import msvcrt

    def _lock(number: int, shared: bool, wait: bool) -> None:
        msvcrt.locking(number, msvcrt.LK_LOCK if wait else msvcrt.LK_NBLCK, 1)
else:
    try:
        import fcntl
    except ImportError:

        def _lock(number: int, shared: bool, wait: bool) -> None:
            raise Error("this system has no locks of files; expected Linux, macOS or Windows")
    else:

        def _lock(number: int, shared: bool, wait: bool) -> None:
            kind = fcntl.LOCK_SH if shared else fcntl.LOCK_EX
            fcntl.flock(number, kind if wait else kind | fcntl.LOCK_NB)


def lock(file: IO[Any], *, shared: bool = False, wait: bool = False) -> bool:
    """Lock an open file until it is closed; False: another process has it, and `wait` is not set.

    Raises `Error`: the system has no such locks.
    """
    try:
        _lock(file.fileno(), shared, wait)
    except (BlockingIOError, PermissionError):  # PermissionError: Windows
        return False
    return True
