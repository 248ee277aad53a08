"""Opening a motion's file, whoever wrote it: a native one in full, another tool's for looking."""

from __future__ import annotations

from pathlib import Path

from llsrbm.formats.reading import load_motion
from llsrbm.motion.archive import keys
from llsrbm.motion.files import Trajectory, load
from llsrbm.motion.whole_body import WholeBodyMotion

_SCHEMA = "schema"  # the key that every native file has, and no other tool's


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
    return load(path) if is_native(path) else load_motion(path, robot, fps=fps)


def is_native(path: str | Path) -> bool:
    """Whether a file is this project's as far as its kind goes, damaged ones among them."""
    held = keys(path)
    # `load` says best what is wrong with an archive that cannot be listed.
    return _SCHEMA in held or (not held and Path(path).suffix.lower() == ".npz")
