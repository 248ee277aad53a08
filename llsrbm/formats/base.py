"""What an export format is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from llsrbm.motion.files import Trajectory


@dataclass(frozen=True)
class Format:
    """One file format.

    Attributes:
        name: as on the command line.
        description: one line.
        suffix: of file names, with the dot.
        write: (trajectory, path, frames/s) -> None; raises `InputError` if it cannot.
    """

    name: str
    description: str
    suffix: str
    write: Callable[[Trajectory, str | Path, float], None]
