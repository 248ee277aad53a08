"""CSV for a person: a column a number, names with units, time first (PlotJuggler, pandas)."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from llsrbm.formats.base import Format
from llsrbm.formats.columns import columns
from llsrbm.motion.files import Trajectory
from llsrbm.motion.writing import replacing


def write_table(trajectory: Trajectory, path: str | Path, fps: float) -> None:
    """Write rows 1/fps apart, and one exactly at each event: see `llsrbm.formats.columns`."""
    listed = list(columns(trajectory, fps))
    with replacing(path) as file:
        text = io.TextIOWrapper(file, encoding="utf-8", newline="")
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(name for name, _ in listed)
        for row in np.column_stack([values for _, values in listed]):
            # 12 digits keep rows that are a rounding apart distinct and the file readable.
            writer.writerow(f"{value:.12g}" for value in row)
        text.flush()
        text.detach()


TABLE = Format(
    "csv",
    "a table for a person: time first, names with units, resampled, with lift-off and touch-down",
    ".csv",
    write_table,
)
