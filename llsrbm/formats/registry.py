"""The formats that there are; adding one is one module and one line here."""

from __future__ import annotations

from llsrbm.errors import InputError
from llsrbm.formats.base import Format
from llsrbm.formats.csv_table import CSV
from llsrbm.formats.design_file import DESIGN
from llsrbm.formats.npz import NPZ

FORMATS: dict[str, Format] = {
    format_.name: format_
    for format_ in (
        NPZ,
        CSV,
        DESIGN,
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
