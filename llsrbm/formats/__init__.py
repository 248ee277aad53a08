"""Export formats, found by name; adding one is one file and one line here."""

from __future__ import annotations

from pathlib import Path

from llsrbm.errors import InputError
from llsrbm.formats.base import Format
from llsrbm.formats.native import NATIVE
from llsrbm.formats.table import TABLE
from llsrbm.motion.files import Trajectory

__all__ = ["Format", "export", "formats", "suffix"]

_FORMATS: dict[str, Format] = {format_.name: format_ for format_ in (NATIVE, TABLE)}


def formats() -> dict[str, str]:
    """Name -> one line."""
    return {name: format_.description for name, format_ in _FORMATS.items()}


def suffix(name: str) -> str:
    """How names of files of a format end, with the dot.

    Raises:
        InputError: no such format.
    """
    return _find(name).suffix


def export(
    trajectory: Trajectory,
    path: str | Path,
    format: str = "npz",  # noqa: A002  # the word of the public interface
    fps: float = 60.0,
) -> None:
    """Write a trajectory to a file.

    Args:
        trajectory: what `llsrbm.plan`, `llsrbm.simulate` or `llsrbm.load` returned.
        path: the file, replaced atomically.
        format: a name in `formats()`.
        fps: frames/s, for formats that have a frame rate.

    Raises:
        InputError: no such format, a frame rate that makes no sense, or a file that cannot be
            written.
    """
    _find(format).write(trajectory, path, fps)


def _find(name: str) -> Format:
    if name not in _FORMATS:
        raise InputError(f'no format "{name}"; the formats are {", ".join(_FORMATS)}')
    return _FORMATS[name]
