"""Unitree's and LAFAN1's table of a motion, the de-facto interchange: no header, a row a frame.

Columns 0-2: position of the root link's origin, m; 3-6: its attitude as a quaternion x, y, z, w
(w last); from 7 on: all joints of the robot's URDF in Pinocchio's order, rad, and m for joints that
slide: of G1 29, legs, waist, arms with wrists. Those that the robot's file holds are where it holds
them. World frame, z up. A row is Pinocchio's q. Quaternions have no jumps of sign.

The file says neither its rate nor its joints: the JSON file beside it, under its name and
".meta.json", does (`fps`, `joint_order`, `columns`, `column_units`, `quaternion_order`): of other
columns or units it is not opened. 30 frames/s unless asked otherwise, for the converters of mjlab
and BeyondMimic take a file to have 30 where nobody tells them; they resample it and take
differences, which smears lift-off and touchdown: the format "motion-npz" has exact velocities.

Can be opened: with the rate and the joints of the file beside it, else with the rate that is asked
for and in the robot's order, with held joints or without; of G1 also 27 (no waist roll and pitch)
and 23 (no wrist pitch and yaw either), as Unitree's training code has them. Held joints that move
are left out, with a remark. Velocities are then differences of the frames around, so that impacts
are smeared over two frames; which feet stand is told from how they move.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from llsrbm.arrays import Array
from llsrbm.errors import FileFormatError
from llsrbm.formats.base import (
    Format,
    Options,
    Purpose,
    Written,
    frames_of,
    joints_beside,
    read_beside,
)
from llsrbm.formats.foreign import (
    MOST_FRAMES,
    checked_motion,
    checked_rate,
    joint_columns,
    joint_orders,
    one_rate,
)
from llsrbm.motion.bodies import urdf_joints
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.robots import Robot
from llsrbm.text_files import read_text

_XYZW = [1, 2, 3, 0]
_WXYZ = [3, 0, 1, 2]
_ROOT, _ROOT_UNITS = ("x", "y", "z", "qx", "qy", "qz", "qw"), "mmm1111"
_WHAT = (
    "rows of numbers with commas between them, without a header: root x, y, z [m], quaternion "
    "x, y, z, w, joints [rad, m]"
)
_EXPECTED = f"expected {_WHAT}"
_LARGEST = 32 * 1024**2  # bytes
_OTHER_SEPARATORS = {None: "spaces", ";": "semicolons", "\t": "tabs"}  # None: any white space
_MOST_COLUMNS = 200  # a row of more is not parsed


def _write(written: Written, path: Path, options: Options) -> None:
    motion = frames_of(written, options)
    order = urdf_joints(motion.robot)
    root = motion.base_position, motion.base_quat[:, _XYZW]
    rows = np.hstack([*root, order.position(motion)])
    np.savetxt(path, rows, fmt="%.9f", delimiter=",")
    UNITREE_CSV.write_beside(
        path,
        written,
        options,
        quaternion_order="xyzw",
        joint_order=list(order.joints),
        columns=[*_ROOT, *order.joints],
        column_units=[*_ROOT_UNITS, *order.units],
    )


def _read(path: Path, robot: Robot, fps: float | None) -> WholeBodyMotion:
    beside = read_beside(path)
    rows = _rows(path, robot)
    stated, requested = (
        None if each is None else checked_rate(each, f"{path}: fps")
        for each in (beside.get("fps"), fps)
    )
    rate, remarks = one_rate(stated, requested)
    if rate is None:
        raise FileFormatError(
            f"{path}: the file does not say its rate; expected frames per second with it, or "
            f"{path.name}.meta.json beside it"
        )
    order = beside.get("quaternion_order", "xyzw")
    if order != "xyzw":
        raise FileFormatError(
            f'{path}.meta.json: quaternion_order: expected "xyzw", got {json.dumps(order):.40}'
        )
    order, found = _joints(beside, rows[:, 7:], robot, path)
    _check_columns(beside, rows.shape[1], robot, path)
    qpos = np.hstack([rows[:, :3], rows[:, 3:7][:, _WXYZ], rows[:, 7:][:, order]])
    origin, found = UNITREE_CSV.name, (*remarks, *found)
    return checked_motion(robot, origin, str(path), rate, qpos, remarks=found, w_first=False)


def _joints(
    beside: dict[str, Any], position: Array, robot: Robot, path: Path
) -> tuple[list[int], tuple[str, ...]]:
    named = "joint_order" in beside
    where = f"{path}.meta.json: joint_order" if named else str(path)
    names = joints_beside(beside, path)
    if names is None:
        names = _names(beside, position.shape[1], robot)
    return joint_columns(names, position, robot, where)


def _names(beside: dict[str, Any], count: int, robot: Robot) -> Any:
    """Joints of so many columns: those that the file beside the table has."""
    return beside["joint_order"] if "joint_order" in beside else list(_orders(robot)[count])


def _check_columns(beside: dict[str, Any], width: int, robot: Robot, path: Path) -> None:
    """Raise `FileFormatError` if the file beside the table has other columns, or in other units."""
    names = _names(beside, width - len(_ROOT), robot)
    every = urdf_joints(robot)
    units = dict(zip(every.joints, every.units, strict=True))
    for key, expected in (
        ("columns", [*_ROOT, *([] if "joint_order" in beside else names)]),
        ("column_units", [*_ROOT_UNITS, *(units[name] for name in names)]),
    ):
        given = beside.get(key, expected)
        if not isinstance(given, list) or given[: len(expected)] != expected:
            pairs = zip(given, expected, strict=False) if isinstance(given, list) else ()
            one, other = next((pair for pair in pairs if pair[0] != pair[1]), (given, expected))
            raise FileFormatError(
                f"{path}.meta.json: {key}: expected {json.dumps(other):.60}, got "
                f"{json.dumps(one):.60}; such tables are not converted"
            )


def _orders(robot: Robot) -> dict[int, tuple[str, ...]]:
    """Joints of tables, by their number."""
    return joint_orders(urdf_joints(robot).joints, robot)


def _rows(path: Path, robot: Robot) -> Array:
    text = read_text(path, _WHAT, _LARGEST)
    if text.count("\n") > 2 * MOST_FRAMES:  # before there is a string of each
        raise FileFormatError(f"{path}: more than {MOST_FRAMES} rows; {_EXPECTED}")
    lines = [line for line in text.splitlines() if line.strip()]
    if len(lines) > MOST_FRAMES:
        raise FileFormatError(f"{path}: {len(lines)} rows; at most {MOST_FRAMES} are read")
    rows: list[list[float]] = []
    widths = sorted(len(_ROOT) + count for count in _orders(robot))
    for number, line in enumerate(lines, start=1):
        columns = line.count(",") + 1
        if columns > _MOST_COLUMNS:
            raise _wrong_width(path, number, columns, widths, robot)
        try:
            row = [_number(cell) for cell in line.split(",")]
        except ValueError as error:
            raise FileFormatError(f"{path}: {_no_numbers(line, number)}") from error
        if columns not in widths:
            raise _wrong_width(path, number, columns, widths, robot)
        widths = [columns]
        rows.append(row)
    return np.array(rows, dtype=np.float64).reshape(-1, widths[0])


def _number(cell: str) -> float:
    """A cell's number; raises `ValueError`: it is none, or has digits as Python alone has them."""
    if "_" in cell or not cell.isascii():
        raise ValueError(cell)
    return float(cell)


def _no_numbers(line: str, row: int) -> str:
    """A message on a row that is not all numbers, with what would be accepted."""
    if line.rstrip().endswith(","):
        return f"row {row} ends with a comma; {_EXPECTED}"
    for separator, name in _OTHER_SEPARATORS.items():
        cells = line.split(separator)
        if len(cells) > len(_ROOT) and all(map(_is_number, cells)):
            return f"row {row} has {name} between its numbers; {_EXPECTED}"
    if row == 1:
        return (
            f"begins with a header, or is no table; {_EXPECTED}; a file with a header may have "
            "other units (ProtoMotions': cm, degrees, Euler angles)"
        )
    return f"row {row}: not all of it is numbers; {_EXPECTED}"


def _is_number(cell: str) -> bool:
    try:
        _number(cell)
    except ValueError:
        return False
    return True


def _wrong_width(
    path: Path, row: int, columns: int, widths: list[int], robot: Robot
) -> FileFormatError:
    orders = _orders(robot)
    counts = sorted(width - 7 for width in widths)
    listed = " or ".join(f"{count} ({_outline(orders[count])})" for count in counts)
    near = ""
    if columns + 1 in widths:
        near = "; Euler angles and exponential maps are not read"
    elif columns - 1 in widths:
        near = "; a column of the time, or of the frame's number, is not read"
    return FileFormatError(
        f"{path}: row {row} has {columns} columns; expected {' or '.join(map(str, sorted(widths)))}"
        f": 7 of the root and, of robot {robot.name}, {listed} joints{near}"
    )


def _outline(joints: tuple[str, ...]) -> str:
    """The first and the last, and where two neighbours are not of one limb."""
    return f"{joints[0]} to {joints[-1]}"


UNITREE_CSV = Format(
    name="unitree-csv",
    title="motion reference for mjlab and others, no header: root, quaternion x y z w, joints",
    purpose=Purpose.LEARNING,
    suffix=".csv",
    write=_write,
    write_motion=_write,
    conventions=__doc__,
    options=("fps", "pad"),
    defaults=Options(fps=30.0),
    read=_read,
    recognises=lambda path: path.suffix.lower() == ".csv",
)
