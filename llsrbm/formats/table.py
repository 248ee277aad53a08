"""CSV for a person: a column a number, names with units, time first (PlotJuggler, pandas)."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from llsrbm.formats.base import Format
from llsrbm.formats.columns import Column, plan_columns, rollout_columns
from llsrbm.motion.files import Trajectory
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.writing import replacing

_COLUMNS: dict[type, Callable[[Any, float], Iterator[Column]]] = {
    Plan: plan_columns,
    Rollout: rollout_columns,
}


def write_table(trajectory: Trajectory, path: str | Path, fps: float) -> None:
    """Write rows 1/fps apart, and one exactly at each event: see `llsrbm.formats.columns`."""
    columns = list(_COLUMNS[type(trajectory)](trajectory, fps))
    with replacing(path) as file:
        text = io.TextIOWrapper(file, encoding="utf-8", newline="")
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(name for name, _ in columns)
        for row in np.column_stack([values for _, values in columns]):
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
