"""The package as it is installed: its version, and where its assets are."""

from functools import cache
from importlib import metadata
from pathlib import Path

from llsrbm.errors import Error


@cache
def package_version() -> str:
    """As installed; "0+source" when the sources are imported without being installed."""
    try:
        return metadata.version("llsrbm")
    except metadata.PackageNotFoundError:
        return "0+source"


@cache
def assets_directory() -> Path:
    """The project's assets: inside the package when installed, beside it in a checkout. Raises
    `Error`: neither is there.
    """
    package = Path(__file__).resolve().parent
    candidates = (package / "assets", package.parent / "assets")
    for candidate in candidates:
        if (candidate / "robots").is_dir():
            return candidate
    raise Error(f"the assets are missing; looked in {', '.join(map(str, candidates))}")
