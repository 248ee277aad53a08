"""Figures in the paper's arrangement: curves over the phases, and rows of snapshots."""

from collections.abc import Sequence
from itertools import islice
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import llsrbm
from llsrbm.formats.base import Options
from llsrbm.formats.pictures.video import pictures

STYLE = {"llsrbm-plus": "-", "llsrbm": "-.", "srbm": "--"}
TITLE = {"llsrbm-plus": "LL-SRBM+", "llsrbm": "LL-SRBM", "srbm": "SRBM"}
COLOURS = ("tab:red", "tab:green", "tab:blue")
SNAPSHOT_RATE = 25.0  # pictures/s, of which those nearest to the instants are taken
mpl.rcParams |= {"font.size": 8, "axes.grid": True, "grid.alpha": 0.3, "legend.fontsize": 7}


def axes(
    rows: int, columns: int, size: tuple[float, float] = (7.2, 4.6)
) -> tuple[Figure, list[Axes]]:
    """A figure and its axes, row by row."""
    figure = Figure(figsize=size, layout="constrained")
    found = figure.subplots(rows, columns, squeeze=False)
    return figure, [ax for row in found for ax in row]


def phases(ax: Axes, lift_off: float, touchdown: float) -> None:
    """The paper's vertical lines between take-off, flight and landing."""
    for instant in (lift_off, touchdown):
        ax.axvline(instant, color="black", linestyle=":", linewidth=0.8)
    ax.set_xlabel("time [s]")


def snapshots(
    motions: Sequence[tuple[str, llsrbm.Rollout]], shares: Sequence[float], path: Path
) -> None:
    """A row of pictures of each motion, at shares of the time from take-off's middle to the end."""
    figure, cells = axes(len(motions), len(shares), (1.9 * len(shares), 1.5 * len(motions)))
    for row, (title, rollout) in enumerate(motions):
        length = float(rollout.time[-1] - rollout.time[0])
        wanted = [round(share * length * SNAPSHOT_RATE) for share in shares]
        options = Options(fps=SNAPSHOT_RATE, size=(480, 380))
        taken = dict(enumerate(islice(pictures(rollout, options), max(wanted) + 1)))
        for column, (index, share) in enumerate(zip(wanted, shares, strict=True)):
            ax = cells[row * len(shares) + column]
            ax.imshow(taken[index])
            ax.set(xticks=[], yticks=[])
            ax.set_title(f"{title}, {share * length:.2f} s", fontsize=7)
    figure.savefig(path, dpi=130)


def degrees(values: np.ndarray) -> np.ndarray:
    return np.degrees(values)
