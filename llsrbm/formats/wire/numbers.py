"""A table of numbers as text."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from llsrbm.arrays import Array

_DIGITS = "%.9g"  # more than the 24 bits that messages hold


def write_numbers(path: Path, header: Sequence[str], rows: Array) -> None:
    """Write rows (K, n) under a header of n names, separated by commas."""
    names = ",".join(header)
    np.savetxt(path, rows, fmt=_DIGITS, delimiter=",", header=names, comments="", encoding="utf-8")


def interleaved(*columns: Array) -> Array:
    """(K, n m): of m arrays (K, n) all of the first column, then all of the second, and so on."""
    stacked = np.stack(columns, axis=-1)
    return stacked.reshape(len(stacked), -1)
