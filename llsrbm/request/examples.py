"""Designs to start from: the paper's experiments and some that show what else there is."""

from __future__ import annotations

import os
import re

from llsrbm.errors import InputError
from llsrbm.request.design import SUFFIX, Design, load_design
from llsrbm.robots.assets import assets_directory
from llsrbm.robots.schema import choices


def examples() -> dict[str, Design]:
    """Name -> design, in the order in which to show them."""
    files = sorted((assets_directory() / "designs").glob(f"*{SUFFIX}"))
    # A number before the name keeps the order.
    return {
        re.sub(r"^\d+-", "", path.name.removesuffix(SUFFIX)): load_design(path) for path in files
    }


def find_design(name_or_path: str) -> Design:
    """The example of that name, or the design in the file at that path.

    What ends in ".json" or contains a path separator is a path.

    Raises:
        InputError: no such example.
        FileFormatError: the file is no design.
    """
    if name_or_path.endswith(".json") or os.sep in name_or_path:
        return load_design(name_or_path)
    known = examples()
    if name_or_path not in known:
        raise InputError(
            f'no design "{name_or_path}"; {choices(name_or_path, known)}, '
            "or the path of a design's file (.json)"
        )
    return known[name_or_path]
