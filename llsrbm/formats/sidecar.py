"""Everything beside the numbers, for formats that have no room for it: JSON beside the file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from llsrbm.errors import FileFormatError
from llsrbm.motion.trajectory import Trajectory, description

SUFFIX = ".meta.json"  # after the whole name of the file that it is of
_LARGEST = 4 * 1024**2  # bytes; ours have some ten thousand


def described(trajectory: Trajectory, format_name: str, **own: Any) -> dict[str, Any]:
    """Description of an exported trajectory, as plain data.

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


def read_sidecar(path: Path) -> dict[str, Any]:
    """The JSON beside a file; nothing where there is none.

    Raises:
        FileFormatError: there is one, and it is unreadable or no JSON object.
    """
    beside = path.with_name(path.name + SUFFIX)
    try:
        with beside.open("rb") as file:
            content = file.read(_LARGEST + 1)
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise FileFormatError(f"{beside}: cannot be read: {error.strerror or error}") from error
    if len(content) > _LARGEST:
        raise FileFormatError(f"{beside}: more than {_LARGEST} bytes; expected what is beside")
    try:
        table = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise FileFormatError(f"{beside}: damaged: expected a JSON object") from error
    if not isinstance(table, dict):
        raise FileFormatError(f"{beside}: expected a JSON object")
    return table
