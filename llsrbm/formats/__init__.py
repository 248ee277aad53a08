"""Files that other tools read, one module a format, and foreign files that can be looked at."""

from __future__ import annotations

from llsrbm.formats.base import ORDERS, Format, Options
from llsrbm.formats.exporting import export, file_name
from llsrbm.formats.reading import load_motion, readable
from llsrbm.formats.registry import FORMATS, find

__all__ = [
    "FORMATS",
    "ORDERS",
    "Format",
    "Options",
    "export",
    "file_name",
    "find",
    "load_motion",
    "readable",
]
