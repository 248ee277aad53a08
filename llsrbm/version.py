"""The package's version, for files and `--version`."""

from __future__ import annotations

from functools import cache
from importlib import metadata


@cache
def package_version() -> str:
    """As installed; "0+source" when the sources are imported without being installed."""
    try:
        return metadata.version("llsrbm")
    except metadata.PackageNotFoundError:
        return "0+source"
