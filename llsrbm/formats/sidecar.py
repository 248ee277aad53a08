"""Everything beside the numbers, for formats that have no room for it: JSON beside the file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from llsrbm.motion.description import description
from llsrbm.motion.files import Trajectory

SUFFIX = ".meta.json"  # after the whole name of the file that it is of


def described(trajectory: Trajectory, format_name: str, **own: Any) -> dict[str, Any]:
    """What there is to say about an exported trajectory, as plain data.

    Args:
        trajectory: what was exported.
        format_name: into what.
        own: what is peculiar to the file: rate, orders, columns.
    """
    return {"format": format_name, **own, **description(trajectory)}


def write_sidecar(path: Path, trajectory: Trajectory, format_name: str, **own: Any) -> None:
    """Write `described` beside `path`, under its name and `.meta.json`."""
    text = json.dumps(described(trajectory, format_name, **own), indent=1, allow_nan=False)
    path.with_name(path.name + SUFFIX).write_text(text + "\n", encoding="utf-8")
