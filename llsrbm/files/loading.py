"""Reading any of the project's native files, told apart by their `schema`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from llsrbm.files import plan_file, rollout_file
from llsrbm.files.archive import LARGEST, Arrays, read_archive
from llsrbm.files.native_file import check_schema
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout

Trajectory = Plan | Rollout

_READERS: dict[str, Callable[[Arrays, str | Path], Trajectory]] = {
    plan_file.SCHEMA: plan_file.plan_from_arrays,
    plan_file.FIRST_SCHEMA: plan_file.plan_from_arrays,
    rollout_file.SCHEMA: rollout_file.rollout_from_arrays,
}


def load(path: str | Path, *, largest: int = LARGEST) -> Trajectory:
    """Read a native file (`Plan.save`, `Rollout.save`).

    A stranger's file may be opened: nothing in it is run, no other file is read that it names, and
    what it may take of memory is limited.

    Args:
        path: of the file.
        largest: bytes, of the file and of its arrays together.

    Raises:
        FileFormatError: unreadable, damaged, or of no schema this version knows.
    """
    arrays = read_archive(path, largest=largest)
    return _READERS[check_schema(arrays, path, tuple(_READERS))](arrays, path)
