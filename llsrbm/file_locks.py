"""Locks of open files between processes; the system releases them when a process ends.

Linux and macOS have them by `fcntl`, Windows by `msvcrt`, where a shared lock is an exclusive one.
"""

import importlib
from contextlib import suppress
from typing import IO, Any

from llsrbm.errors import Error

_system: Any = None  # the module of the system's own locks
for _name in ("fcntl", "msvcrt"):
    with suppress(ImportError):
        _system = importlib.import_module(_name)
        break


def lock(file: IO[Any], *, shared: bool = False) -> bool:
    """Lock an open file until it is closed; False: another process has it. Raises
    `Error`: the system has no such locks.
    """
    if _system is None:
        raise Error("this system has no locks of files; expected Linux, macOS or Windows")
    try:
        if hasattr(_system, "flock"):
            kind = _system.LOCK_SH if shared else _system.LOCK_EX
            _system.flock(file, kind | _system.LOCK_NB)
        else:
            _system.locking(file.fileno(), _system.LK_NBLCK, 1)
    except (BlockingIOError, PermissionError):  # the latter on Windows
        return False
    return True
