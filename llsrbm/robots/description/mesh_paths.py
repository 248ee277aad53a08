"""Where the meshes of a URDF are: the same place from whichever folder a robot is read.

A name without a scheme is looked up in the URDF's folder and in the one above. `package://NAME/...`
and `model://NAME/...` are looked up in the folders above the URDF: in those that are called NAME or
whose package.xml says so, and in a folder NAME within them; then where ROS_PACKAGE_PATH and
AMENT_PREFIX_PATH point, and among installed packages of robot data.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

from llsrbm.errors import RobotFileError, printable

LONGEST_PATH = 300
"""Characters of a path in a message."""

# Of meshes that can be read.
_SUFFIXES = frozenset({".stl", ".dae", ".obj", ".glb", ".gltf", ".ply", ".off"})
_PACKAGE = re.compile(r"<name>\s*([^<\s]+)\s*</name>")


class MeshPaths:
    """Looks up the meshes of one URDF."""

    def __init__(self, urdf: Path) -> None:
        self._folder = urdf.absolute().parent
        self._packages: dict[str, tuple[Path, ...]] = {}

    def find(self, name: str, where: str) -> Path:
        """The file of a mesh; `where`: how messages begin. Raises `RobotFileError`: there is none,
        or it is of a kind that cannot be read.
        """
        shown = f'{where}: mesh "{printable(name, 200)}"'
        if "\\" in name or re.match(r"[A-Za-z]:", name):
            raise RobotFileError(f"{shown} is named as Windows does; expected / in paths")
        scheme, sign, rest = name.partition("://")
        if not sign:
            rest, scheme = name, ""
        elif scheme not in ("package", "model", "file"):
            raise RobotFileError(f"{shown}: expected package://, model://, file:// or a path")
        tried = list(self._candidates(scheme, rest))
        if scheme and "%" in rest:
            tried += self._candidates(scheme, unquote(rest))
        found = next((path for path in tried if is_there(path)), None)
        if found is None:
            package, expected = rest.partition("/")[0], f"it at {self._folder / rest}"
            if scheme in ("package", "model"):
                expected = (
                    f"it at {tried[0]}"
                    if tried
                    else (
                        f'a folder "{printable(package)}" above the URDF, or one whose package.xml '
                        "has that name, or it in ROS_PACKAGE_PATH"
                    )
                )
            raise RobotFileError(f"{shown} is missing; expected {expected}")
        if found.suffix.lower() not in _SUFFIXES:
            raise RobotFileError(
                f"{shown} cannot be read; expected a file {', '.join(sorted(_SUFFIXES))}"
            )
        return found

    def _candidates(self, scheme: str, rest: str) -> list[Path]:
        if scheme in ("package", "model"):
            package, _, inside = rest.partition("/")
            if package not in self._packages:
                self._packages[package] = tuple(_package_folders(package, self._folder))
            return [home / inside for home in self._packages[package]]
        return [self._folder / rest, self._folder.parent / rest]


def _package_folders(package: str, folder: Path) -> Iterator[Path]:
    """Folders that a package may be, from the nearest on."""
    paths = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    shares = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    listed = [Path(path) for path in paths if path]
    listed += [Path(path) / "share" for path in shares if path]
    listed += installed_shares()
    for place in (folder, *folder.parents, *listed):
        if place.name == package or _name_in_xml(place) == package:
            yield place
        if (place / package).is_dir():
            yield place / package


def is_there(path: Path) -> bool:
    """Whether there is such a file; none has a name that the system cannot have."""
    try:
        return path.is_file()
    except OSError:
        return False


def installed_shares() -> list[Path]:
    """Folders `share` where packages of robot data may be installed."""
    roots = [Path(entry) / "cmeel.prefix" for entry in sys.path if entry]
    return [root / "share" for root in (*roots, Path(sys.prefix))]


def _name_in_xml(folder: Path) -> str | None:
    try:
        text = (folder / "package.xml").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    named = _PACKAGE.search(text)
    return named.group(1) if named else None
