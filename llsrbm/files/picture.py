"""Pictures as files, drawn by matplotlib (`pip install "llsrbm[pictures]"`)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from llsrbm.errors import InputError, require
from llsrbm.files.atomic import check_place, staged

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SUFFIXES = (".png", ".svg", ".pdf")
"""Of pictures that can be written."""


def check_picture(path: Path) -> None:
    """Raise `InputError`, as `write_figure` would in the end: no picture has such a name, it cannot
    be written there, or matplotlib is not installed.
    """
    if path.suffix not in SUFFIXES:
        kinds = ", ".join(SUFFIXES)
        raise InputError(f"{path}: expected a name that ends in one of {kinds}")
    require("pictures need matplotlib", "pictures", "matplotlib")
    check_place(path)


def write_figure(figure: Figure, path: Path) -> None:
    """Write a figure; the path's suffix is its kind. Raises as `check_picture`."""
    check_picture(path)
    with staged(path) as draft:
        figure.savefig(draft)
