"""Reading motions in MuJoCo's coordinates out of npz files: numbers only, no MJCF, no pickles.

See `llsrbm.formats.mujoco.folder` for what is read.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Sequence
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import FileFormatError
from llsrbm.files.archive import (
    LARGEST,
    Arrays,
    read_archive,
    read_open_archive,
    refusing_damage,
)
from llsrbm.motion.derivatives import velocities
from llsrbm.motion.whole_body import WholeBodyMotion, motion_of_states
from llsrbm.robots import Robot

Array = NDArray[np.float64]

_MOTION = "motion.npz"  # in a folder, or in its zip
_KEYS = ("qpos", "qvel", "time", "fps", "frequency", "joint_names", "jnt_type", "split_points")
_EXPECTED = 'expected an npz file with "qpos", or the folder or zip of an export for MuJoCo'
_RATE = 'a rate as "time", "fps" or "frequency" in the file, or given with it (--fps 500, say)'
_FREE = 0  # MuJoCo's number of a free joint's type
_ROOT = 7  # numbers of the root in qpos
_UNIT = 1e-2  # by which a quaternion's norm may miss 1: single precision, and rounding in files
_EVEN = 1e-3  # of a step: frames that are that even have a rate
_SAME_RATE = 2e-3  # share by which rates may differ: 60 frames/s, and 59.94
_FASTEST = 1e6  # frames/s


def recognises(path: Path) -> bool:
    """Whether it looks like something that `read_motion` reads; opens it, and never raises."""
    try:
        if path.is_dir():
            return (path / _MOTION).is_file() and (path / "scene.xml").is_file()
        with (
            path.open("rb") as file,
            refusing_damage(path, _EXPECTED),
            zipfile.ZipFile(file) as archive,
        ):
            names = archive.namelist()
    except (OSError, FileFormatError):
        return False
    # Ours has the same key among others, under a schema.
    return ("qpos.npy" in names and "schema.npy" not in names) or bool(_members(names))


def read_motion(path: Path, robot: Robot, fps: float | None) -> WholeBodyMotion:
    """A motion out of such a folder, its zip, or an npz file with `qpos`.

    Args:
        path: of the file or folder.
        robot: whose motion it is.
        fps: frames/s, for files that do not say so.

    Raises:
        FileFormatError: damaged, not such a file, of another robot, of several motions, or without
            a rate.
    """
    arrays, where = _arrays(path)
    if "qpos" not in arrays:
        raise FileFormatError(f'{where}: key "qpos" is missing; {_EXPECTED}')
    joints = len(robot.joint_names)
    order = _joint_order(arrays, robot, where)
    qpos = _numbers(arrays, "qpos", (None, _ROOT + joints), where)
    if len(qpos) < 2:
        raise FileFormatError(f"{where}: {len(qpos)} frames; expected 2 or more")
    splits = np.ravel(arrays.get("split_points", np.zeros(0)))
    if len(splits) > 2:
        raise FileFormatError(
            f"{where}: {len(splits) - 1} motions one after the other; expected one"
        )
    qpos = np.hstack([_unit_quaternions(qpos[:, :_ROOT], where), qpos[:, _ROOT:][:, order]])
    time, rate = _times(arrays, len(qpos), fps, where)
    if "qvel" in arrays:
        qvel = _numbers(arrays, "qvel", (len(qpos), _ROOT - 1 + joints), where)
        qvel = np.hstack([qvel[:, : _ROOT - 1], qvel[:, _ROOT - 1 :][:, order]])
    else:
        qvel = velocities(time, qpos)
    return motion_of_states(robot, "mujoco", time, qpos, qvel, rate)


def _arrays(path: Path) -> tuple[Arrays, str]:
    """What is in it, and its name for messages."""
    if path.is_dir():
        inner = path / _MOTION
        return read_archive(inner, only=_KEYS, expected=_EXPECTED), str(inner)
    try:
        with path.open("rb") as file, refusing_damage(path, _EXPECTED):
            if zipfile.is_zipfile(file):
                with zipfile.ZipFile(file) as archive:
                    members = _members(archive.namelist())
                    if len(members) == 1:
                        return _member(archive, members[0], path)
    except OSError as error:
        raise FileFormatError(
            f"{path}: cannot be read: {error.strerror or error}; {_EXPECTED}"
        ) from error
    return read_archive(path, only=_KEYS, expected=_EXPECTED), str(path)


def _members(names: Sequence[str]) -> list[str]:
    """Motions in the folders that a zip has."""
    return [
        name
        for name in names
        if PurePosixPath(name).name == _MOTION
        and str(PurePosixPath(name).with_name("scene.xml")) in names
    ]


def _member(archive: zipfile.ZipFile, name: str, path: Path) -> tuple[Arrays, str]:
    where = f"{path}: {name}"
    size = archive.getinfo(name).file_size
    if size > LARGEST:
        raise FileFormatError(f"{where}: {size} bytes; at most {LARGEST} are read")
    return read_open_archive(
        io.BytesIO(archive.read(name)), where, only=_KEYS, expected=_EXPECTED
    ), where


def _joint_order(arrays: Arrays, robot: Robot, where: str) -> list[int]:
    """Places of the robot's joints among those of the file."""
    if "joint_names" in arrays:
        names = _names(arrays, robot, where)
    else:
        # MuJoCo takes its time to import.
        from llsrbm.simulation.scene import joints_in_model_order

        names = list(joints_in_model_order(robot))
    if sorted(names) != sorted(robot.joint_names):
        raise FileFormatError(
            f"{where}: the joints are {', '.join(names) or 'none'}; expected those of "
            f"{robot.name}: {', '.join(robot.joint_names)}"
        )
    return [names.index(name) for name in robot.joint_names]


def _names(arrays: Arrays, robot: Robot, where: str) -> list[str]:
    """The file's names of joints but for the free one, which LocoMuJoCo's files name as well."""
    given = arrays["joint_names"]
    if given.dtype.kind not in "US" or given.ndim != 1:
        raise FileFormatError(f'{where}: key "joint_names": expected a list of names')
    names = [
        name.decode("utf-8", "replace") if isinstance(name, bytes) else str(name)
        for name in given.tolist()
    ]
    types = np.ravel(arrays.get("jnt_type", np.zeros(0)))
    free = names[:1] if len(types) and types[0] == _FREE else []
    if not free and len(names) == len(robot.joint_names) + 1 and names[0] not in robot.joint_names:
        free = names[:1]
    return names[len(free) :]


def _times(
    arrays: Arrays, count: int, given: float | None, where: str
) -> tuple[Array, float | None]:
    """(K,) s from 0 on, and frames/s, None if they are not even."""
    rates = [rate for rate in (_rate(arrays, where), given) if rate is not None]
    if "time" in arrays:
        time = _numbers(arrays, "time", (count,), where)
        steps = np.diff(time)
        mean = float(time[-1] - time[0]) / (count - 1)
        if not (steps > 0).all():
            raise FileFormatError(f'{where}: key "time": expected seconds that increase')
        if np.abs(steps - mean).max() > _EVEN * mean:
            if rates:
                raise FileFormatError(
                    f"{where}: its frames are not even, by its own times; expected no rate for them"
                )
            return time - time[0], None
        rates.append(1 / mean)
    if not rates:
        raise FileFormatError(f"{where}: it does not say its rate; expected {_RATE}")
    rate = rates[0]
    for other in rates:
        if not (np.isfinite(other) and 0 < other <= _FASTEST):
            raise FileFormatError(f"{where}: {other:g} frames/s; expected {_RATE}")
        if abs(other - rate) > _SAME_RATE * rate:
            raise FileFormatError(
                f"{where}: {rate:g} frames/s by one account, {other:g} by another; expected one"
            )
    return np.arange(count) / rate, rate


def _rate(arrays: Arrays, where: str) -> float | None:
    for key in ("fps", "frequency"):
        if key in arrays:
            value: NDArray[Any] = np.ravel(arrays[key])
            if len(value) != 1 or value.dtype.kind not in "fiu" or not value[0] > 0:
                raise FileFormatError(f'{where}: key "{key}": expected frames/s, a number above 0')
            return float(value[0])
    return None


def _numbers(arrays: Arrays, key: str, shape: tuple[int | None, ...], where: str) -> Array:
    """The array at `key`, checked; None in its shape is any length."""
    value = arrays[key]
    wanted = ", ".join("frames" if size is None else str(size) for size in shape)
    if value.ndim != len(shape) or any(
        size is not None and size != got for size, got in zip(shape, value.shape, strict=True)
    ):
        got = ", ".join(map(str, value.shape))
        raise FileFormatError(f'{where}: key "{key}": expected shape ({wanted}), got ({got})')
    if value.dtype.kind not in "fiu":
        raise FileFormatError(f'{where}: key "{key}": expected real numbers, got {value.dtype}')
    numbers = value.astype(np.float64)
    if not np.isfinite(numbers).all():
        raise FileFormatError(f'{where}: key "{key}": expected finite numbers')
    if numbers.size and np.abs(numbers).max() > 1e6:
        raise FileFormatError(f'{where}: key "{key}": {np.abs(numbers).max():g}; expected SI units')
    return numbers


def _unit_quaternions(root: Array, where: str) -> Array:
    """The root's (K, 7) with quaternions of norm 1."""
    norm = np.linalg.norm(root[:, 3:], axis=1)
    off = np.abs(norm - 1) > _UNIT
    if off.any():
        frame = int(off.argmax())
        raise FileFormatError(
            f'{where}: key "qpos": frame {frame}: expected a unit quaternion w, x, y, z in columns '
            f"4 to 7, got one of norm {norm[frame]:.3g}"
        )
    return np.hstack([root[:, :3], root[:, 3:] / norm[:, None]])
