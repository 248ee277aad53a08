"""Opening any file that shows a motion, foreign ones among them, for looking and comparing."""

from __future__ import annotations

from pathlib import Path

from llsrbm.errors import FileFormatError, InputError
from llsrbm.files.npz import keys
from llsrbm.formats.base import Format
from llsrbm.formats.registry import FORMATS, find
from llsrbm.motion.trajectory import Trajectory, load
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.robots import load_robot

_SCHEMA = "schema"  # the key that every native file has, and no other tool's


def load_motion(
    path: str | Path,
    robot: str = "anymal",
    format: str | None = None,  # noqa: A002  # the word of the public interface
    fps: float | None = None,
) -> WholeBodyMotion:
    """Open a file that holds a robot's motion, this project's or another tool's.

    Args:
        path: a native file of a plan or a rollout, or a file in a format that `llsrbm formats` says
            can be opened.
        robot: name or robot file of what moves; a native file knows its own.
        format: its name in `llsrbm formats`; None: as the file looks.
        fps: frames/s of a file that does not say its own; of a native file, at which it is sampled
            (None: 60).

    Raises:
        FileFormatError: no such file, a damaged one, or one that no format recognises.
        InputError: no such format, or none that can be opened.
        RobotFileError: no such robot, or a wrong robot file.
    """
    path = Path(path)
    chosen = _recognised(path) if format is None else find(format)
    if chosen.read is None:
        raise InputError(
            f'format "{chosen.name}" is written and not opened; expected {_names(readable())}'
        )
    return chosen.read(path, load_robot(robot), fps)


def readable() -> tuple[Format, ...]:
    """The formats that can be opened."""
    return tuple(each for each in FORMATS.values() if each.read is not None)


def _recognised(path: Path) -> Format:
    """The format whose file it looks like."""
    try:
        if not path.is_dir():
            with path.open("rb"):
                pass
    except OSError as error:
        raise FileFormatError(
            f"{path}: cannot be read: {error.strerror or error}; expected {_names(readable())}"
        ) from error
    for each in readable():
        if each.recognises is not None and each.recognises(path):
            return each
    raise FileFormatError(
        f"{path}: damaged, or of no format that can be opened; expected {_names(readable())}"
    )


def _names(formats: tuple[Format, ...]) -> str:
    *first, last = (f"{each.name} ({each.suffix or 'a folder'})" for each in formats)
    return f"{', '.join(first)} or {last}" if first else last


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
    """True if a file is of this project's kind, damaged or not."""
    held = keys(path)
    # `load` says best what is wrong with an archive that cannot be listed.
    return _SCHEMA in held or (not held and Path(path).suffix.lower() == ".npz")
