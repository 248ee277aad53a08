"""CSV for a person: a column a number, names with units, time first (PlotJuggler, pandas)."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from llsrbm.exporters.base import Format
from llsrbm.trajectory.files import Trajectory
from llsrbm.trajectory.resample import Motion, resample, uniform_times
from llsrbm.trajectory.writing import replacing

Array = NDArray[np.float64]
Column = tuple[str, Array]

_XYZ = ("x", "y", "z")
_WXYZ = ("w", "x", "y", "z")
_TENSOR = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}


def write_table(trajectory: Trajectory, path: str | Path, fps: float) -> None:
    """Write rows 1/fps apart, and one exactly at each lift-off and touch-down.

    The slash in the columns' names makes a tree of them in PlotJuggler.
    """
    times = uniform_times(trajectory, fps, phase_edges=True)
    motion = resample(trajectory, times)
    columns = list(_columns(motion, _leg_names(trajectory)))
    with replacing(path) as file:
        text = io.TextIOWrapper(file, encoding="utf-8", newline="")
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(name for name, _ in columns)
        for row in np.column_stack([values for _, values in columns]):
            # 12 digits keep rows that are a rounding apart distinct and the file readable.
            writer.writerow(f"{value:.12g}" for value in row)
        text.flush()
        text.detach()


def _columns(motion: Motion, legs: Sequence[str]) -> Iterator[Column]:
    yield "time [s]", motion.time
    yield "phase [0 take-off, 1 flight, 2 landing]", motion.phase.astype(np.float64)
    yield from _split("base_position", "m", motion.base_position)
    yield from _split("base_quat", "", motion.base_quat, _WXYZ)
    yield from _split("com", "m", motion.com)
    yield from _split("com_velocity", "m/s", motion.com_velocity)
    yield from _split("angular_velocity", "rad/s", motion.angular_velocity)
    yield from _split("linear_momentum", "kg m/s", motion.linear_momentum)
    yield from _split("angular_momentum", "kg m2/s", motion.angular_momentum)
    for name, (row, column) in _TENSOR.items():
        yield f"inertia/{name} [kg m2]", motion.inertia[:, row, column]
    for i, leg in enumerate(legs):
        yield from _split(f"foot_position/{leg}", "m", motion.foot_position[:, i])
    for i, contact in enumerate(_contact_names(legs, motion.contact_force.shape[1])):
        yield from _split(f"contact_force/{contact}", "N", motion.contact_force[:, i])
    for i, joint in enumerate(motion.joint_names):
        yield f"joint_position/{joint} [rad or m]", motion.joint_position[:, i]
    for i, joint in enumerate(motion.joint_names):
        yield f"joint_velocity/{joint} [rad/s or m/s]", motion.joint_velocity[:, i]


def _split(name: str, unit: str, values: Array, axes: Sequence[str] = _XYZ) -> Iterator[Column]:
    for i, axis in enumerate(axes):
        yield f"{name}/{axis} [{unit}]" if unit else f"{name}/{axis}", values[:, i]


def _leg_names(trajectory: Trajectory) -> list[str]:
    """As in the robot file, when the file says what robot it was made with."""
    count = len(trajectory.leg_mass)
    legs = list(trajectory.robot_parameters.get("legs", ()))
    return legs if len(legs) == count else [f"leg{i}" for i in range(count)]


def _contact_names(legs: Sequence[str], count: int) -> list[str]:
    """Point feet are called as their legs; a planar foot's corners are numbered."""
    if count == len(legs):
        return list(legs)
    if count % len(legs):
        return [f"contact{i}" for i in range(count)]
    return [f"{leg}_{corner}" for leg in legs for corner in range(count // len(legs))]


TABLE = Format(
    "csv",
    "a table for a person: time first, names with units, resampled, with lift-off and touch-down",
    ".csv",
    write_table,
)
