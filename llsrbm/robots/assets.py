"""Where robot files and packages of robot data lie on this machine."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path

from llsrbm.errors import Error, RobotFileError


@cache
def assets_directory() -> Path:
    """The project's assets: inside the package when installed, beside it in a checkout.

    Raises:
        Error: neither is there.
    """
    package = Path(__file__).resolve().parents[1]
    candidates = (package / "assets", package.parent / "assets")
    for candidate in candidates:
        if (candidate / "robots").is_dir():
            return candidate
    raise Error(f"the assets are missing; looked in {', '.join(map(str, candidates))}")


def robot_files() -> dict[str, Path]:
    """Robot name -> its file, by name."""
    return {path.stem: path for path in sorted((assets_directory() / "robots").glob("*.toml"))}


def package_share(package: str, robot_file: Path) -> Path:
    """The folder `share` of an installed package of robot data; `robots` lies in `share/<package>`.

    Raises:
        RobotFileError: the package is not installed.
    """
    roots = [Path(entry) for entry in sys.path if entry]
    roots = [*(root / "cmeel.prefix" for root in roots), Path(sys.prefix)]
    for root in roots:
        if (root / "share" / package / "robots").is_dir():
            return root / "share"
    raise RobotFileError(
        f'{robot_file}: urdf.package: no robot data of a package "{package}" is installed; '
        f"expected a folder share/{package}/robots, as `pip install example-robot-data` makes it"
    )
