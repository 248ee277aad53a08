"""A table for a person (PlotJuggler, pandas): a column a number, names with units, time first.

Rows are 1/fps apart, and there is one exactly at each lift-off and touchdown (of a rollout: at each
change of contact, phase or mode). World frame, SI units, quaternions w, x, y, z without jumps of
sign. Joints that slide are in m, m/s and N. Forces and torques are those of the interval or control
tick that a row falls into. 12 digits. A JSON file beside it has request, robot and solver.
"""

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from llsrbm.arrays import Array
from llsrbm.files.quantity import (
    JOINT,
    LEG,
    PARTS,
    TENSOR,
    TIME,
    Quantity,
    derived,
    entries,
    quantities,
)
from llsrbm.formats.base import Format, Options, Purpose
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.sampling import resample, with_events
from llsrbm.motion.trajectory import Trajectory
from llsrbm.number_text import aligned

Column = tuple[str, Array]


def columns(trajectory: Plan | Rollout, fps: float) -> Iterator[Column]:
    """Rows 1/fps apart, and one exactly at each event (`llsrbm.motion.sampling.events`)."""
    sampled = resample(trajectory, with_events(trajectory, fps))
    of = type(sampled)
    for name, quantity in (quantities(of) | derived(of)).items():
        values = getattr(sampled, name)
        if quantity.listed and TIME in quantity.axes and values is not None:
            yield from _columns(sampled, quantity.column or name, quantity, np.asarray(values))


def _columns(
    trajectory: Plan | Rollout, name: str, quantity: Quantity, values: Array
) -> Iterator[Column]:
    units = [quantity.unit or _codes(quantity.codes_of(trajectory))]
    paths = [name]
    if quantity.axes[-1] == TENSOR:
        values = entries(values)
    for axis in quantity.axes[1:]:
        members = _members(trajectory, axis)
        paths = [f"{path}/{member}" for path in paths for member in members]
        if axis == JOINT:
            sliding = trajectory.sliding_joints
            units = [quantity.unit_of(joint, sliding) for joint in members]
    units = units if len(units) == len(paths) else units * len(paths)
    for path, unit, column in zip(paths, units, values.reshape(len(values), -1).T, strict=True):
        yield f"{path} [{unit}]" if unit else path, column.astype(np.float64)


def _codes(codes: Sequence[str]) -> str:
    return ", ".join(f"{number} {meaning}" for number, meaning in enumerate(codes))


def _members(trajectory: Plan | Rollout, axis: str) -> Sequence[str]:
    """Names along an axis. Point feet's contacts are called as their legs, a sole's numbered."""
    if axis in PARTS:
        return PARTS[axis]
    legs = trajectory.leg_names
    if axis == JOINT:
        return trajectory.joint_names
    if axis == LEG or not isinstance(trajectory, Plan):
        return legs
    count = trajectory.contact_force.shape[1]
    if count == len(legs):
        return legs
    if count % len(legs):
        return [f"contact{i}" for i in range(count)]
    return [f"{leg}_{corner}" for leg in legs for corner in range(count // len(legs))]


def quantity_rows() -> list[str]:
    """The table of quantities as text, for people: what plans and rollouts hold."""
    lines = []
    for of in (Plan, Rollout):
        rows = [
            (name, ", ".join(map(str, q.shape)), q.unit or _codes(q.codes), q.frame, q.meaning)
            for name, q in quantities(of).items()
        ]
        lines += ["", f"{of.__name__}: name, shape, unit, frame, meaning"]
        lines += aligned(rows)
    return lines


def _write(trajectory: Trajectory, path: Path, options: Options) -> None:
    listed = list(columns(trajectory, options.fps))
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(name for name, _ in listed)
        for row in np.column_stack([values for _, values in listed]):
            # 12 digits keep rows that are a rounding apart distinct and the file readable.
            writer.writerow(f"{value:.12g}" for value in row)
    CSV.write_beside(path, trajectory, options, quaternion_order="wxyz")


CSV = Format(
    name="csv",
    title="a table for people, pandas or PlotJuggler: time first, names with units",
    purpose=Purpose.LOOKING,
    suffix=".csv",
    write=_write,
    conventions=__doc__,
    options=("fps",),
)
