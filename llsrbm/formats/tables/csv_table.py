"""A table for a person (PlotJuggler, pandas): a column a number, names with units, time first.

Rows are 1/fps apart, and there is one exactly at each lift-off and touchdown (of a rollout: at each
change of contact, phase or mode). World frame, SI units, quaternions w, x, y, z without jumps of
sign. Joints that slide are in m, m/s and N. Forces and torques are those of the interval or control
tick that a row falls into. 12 digits. A JSON file beside it has request, robot and solver.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from llsrbm.formats.base import Format, Options
from llsrbm.formats.sidecar import write_sidecar
from llsrbm.formats.tables.csv_columns import columns
from llsrbm.motion.trajectory import Trajectory


def write_csv(trajectory: Trajectory, path: Path, options: Options) -> None:
    """Write the table and what stands beside it."""
    listed = list(columns(trajectory, options.fps))
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(name for name, _ in listed)
        for row in np.column_stack([values for _, values in listed]):
            # 12 digits keep rows that are a rounding apart distinct and the file readable.
            writer.writerow(f"{value:.12g}" for value in row)
    write_sidecar(path, trajectory, CSV.name, fps=options.fps, quaternion_order="wxyz")


CSV = Format(
    name="csv",
    title="a table for a person: time first, names with units, rows at lift-off and touchdown",
    suffix=".csv",
    write=write_csv,
    conventions=__doc__,
    options=("fps",),
)
