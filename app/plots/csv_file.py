"""The lines that are shown as a table: CSV, one time column for each set of instants.

Nothing is resampled: each line keeps its own instants. Lines with the same instants share a time
column to their left. Where a line has no value, or is shorter than others, the cell is empty.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from app.plots.charts import Layer, Line, charts
from app.plots.choice import PlotChoice

Array = NDArray[np.float64]


def csv_of(layers: Sequence[Layer], choice: PlotChoice) -> bytes:
    """All lines of the chosen charts, UTF-8; the whole motions, whatever part an axis shows.

    The first row names the columns: "time of plan [s]", "CoM position, x, plan [m]".
    """
    blocks: list[tuple[Array, list[tuple[str, Line]]]] = []
    for chart in charts(choice, layers):
        for line in chart.lines:
            block = next((lines for time, lines in blocks if np.array_equal(time, line.time)), None)
            if block is None:
                block = []
                blocks.append((line.time, block))
            block.append((chart.title, line))
    columns: list[list[str]] = []
    for time, lines in blocks:
        whose = ", ".join(dict.fromkeys(line.title for _, line in lines))
        columns.append([f"time of {whose} [s]", *_cells(time)])
        for title, line in lines:
            unit = f" [{line.unit}]" if line.unit else ""
            columns.append([f"{title}, {line.name}{unit}", *_cells(line.values)])
    length = max(map(len, columns), default=0)
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerows(
        zip(*(column + [""] * (length - len(column)) for column in columns), strict=True)
    )
    return text.getvalue().encode("utf-8")


def _cells(values: Array) -> list[str]:
    # Adding 0 takes the sign off a zero.
    return [f"{value + 0.0:.9g}" if np.isfinite(value) else "" for value in values]
