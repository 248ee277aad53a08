"""Opening a motion's file, whoever wrote it: a native one in full, another tool's for looking."""

from __future__ import annotations

import zipfile
from pathlib import Path

from llsrbm.motion.files import Trajectory, load
from llsrbm.motion.whole_body import WholeBodyMotion

_NATIVE = "schema.npy"  # the member that every native file has


def load_any(
    path: str | Path, robot: str = "anymal", fps: float | None = None
) -> Trajectory | WholeBodyMotion:
    """A plan or a rollout of this project's, or the motion in another tool's file.

    Args:
        path: of the file.
        robot: whose motion it is, where the file is another tool's.
        fps: frames/s, where such a file does not say.

    Raises:
        FileFormatError: unreadable, damaged, or of no format that can be opened.
        RobotFileError: there is no such robot.
    """
    if is_native(path):
        return load(path)
    from llsrbm.formats.reading import load_motion

    return load_motion(path, robot, fps=fps)


def is_native(path: str | Path) -> bool:
    """Whether a file is this project's as far as its kind goes, damaged ones among them."""
    try:
        with zipfile.ZipFile(path) as archive:
            return _NATIVE in archive.namelist()
    except (OSError, zipfile.BadZipFile, ValueError, NotImplementedError):
        # `load` says what is wrong with it.
        return Path(path).suffix.lower() == ".npz"
