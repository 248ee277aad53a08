"""The formats that there are; adding one is one module and one line here."""

from __future__ import annotations

from llsrbm.errors import InputError
from llsrbm.formats.base import Format
from llsrbm.formats.csv_table import CSV
from llsrbm.formats.gif import GIF
from llsrbm.formats.html_replay import HTML
from llsrbm.formats.mp4 import MP4
from llsrbm.formats.npz import NPZ

FORMATS: dict[str, Format] = {
    format_.name: format_
    for format_ in (
        NPZ,
        CSV,
        HTML,
        MP4,
        GIF,
    )
}


def find(name: str) -> Format:
    """The format of that name.

    Raises:
        InputError: there is none.
    """
    if name not in FORMATS:
        raise InputError(f'no format "{name}"; the formats are {", ".join(FORMATS)}')
    return FORMATS[name]
