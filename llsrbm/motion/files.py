"""Reading any of the project's native files, told apart by their `schema`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from llsrbm.errors import FileFormatError
from llsrbm.motion import plan_file, rollout_file
from llsrbm.motion.archive import Arrays, read_archive, text
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout

Trajectory = Plan | Rollout

_READERS: dict[str, Callable[[Arrays, str | Path], Trajectory]] = {
    plan_file.SCHEMA: plan_file.plan_from_arrays,
    plan_file.FIRST_SCHEMA: plan_file.plan_from_arrays,
    rollout_file.SCHEMA: rollout_file.rollout_from_arrays,
}


def load(path: str | Path) -> Trajectory:
    """Read a native file (`Plan.save`, `Rollout.save`).

    Raises:
        FileFormatError: unreadable, damaged, or of no schema this version knows.
    """
    arrays = read_archive(path)
    schema = text(arrays, "schema", path)
    if schema not in _READERS:
        raise FileFormatError(f'{path}: schema "{schema}"; known are {", ".join(_READERS)}')
    return _READERS[schema](arrays, path)
