"""The code of this installation as a key: two machines with the same one compute the same.

A cluster's workers are asked for theirs before they get a job; messages are pickled, so that
another version would misread them, or answer with another planner's jumps.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import app
import llsrbm
from llsrbm.cache import content_key
from llsrbm.installed import assets_directory, package_version

_DATA = ("robots", "jump_types")  # folders of what jumps depend on besides the sources
_SHOWN = 8  # hexadecimal digits of the key, in messages


@dataclass(frozen=True)
class CodeIdentity:
    """Which code this is.

    Attributes:
        version: of the package.
        key: hash of the sources of library and page, and of what robots and jump types are.
        python: its version, as 3.11.
    """

    version: str
    key: str
    python: str

    def __str__(self) -> str:
        return f"llsrbm {self.version} ({self.key[:_SHOWN]}) on Python {self.python}"


def code_identity() -> CodeIdentity:
    """Of the code that runs here, as its files are now."""
    folders = [Path(str(package.__file__)).parent for package in (app, llsrbm)]
    sources = [path for folder in folders for path in sorted(folder.rglob("*.py"))]
    # Names of the files do not count: sources and wheel have them in other places.
    data = [path for kind in _DATA for path in sorted((assets_directory() / kind).glob("*.toml"))]
    key = content_key(*sources, *data).hex()
    return CodeIdentity(package_version(), key, "{}.{}".format(*sys.version_info))
