"""The project's own npz: everything, at the planner's knots or the controller's ticks."""

from __future__ import annotations

from pathlib import Path

from llsrbm.formats.base import Format
from llsrbm.motion.files import Trajectory


def write_native(trajectory: Trajectory, path: str | Path, fps: float) -> None:
    """Write the native file; it keeps knots and ticks, so `fps` does not matter."""
    del fps
    trajectory.save(path)


NATIVE = Format(
    "npz",
    "the native file: every quantity, at the planner's knots or the controller's ticks, no loss",
    ".npz",
    write_native,
)
