"""Reading motions in MuJoCo's coordinates out of npz files: numbers only, no MJCF, no pickles.

See `llsrbm.formats.mujoco.folder` for what is read.
"""

from collections.abc import Mapping
from pathlib import Path, PurePosixPath

import numpy as np

from llsrbm.arrays import Array
from llsrbm.errors import FileFormatError
from llsrbm.files.npz import Arrays, checked, open_archive, read_archive
from llsrbm.files.quantity import POSITION, TIME, VELOCITY, Quantity
from llsrbm.formats.base import ORDERS
from llsrbm.formats.foreign import (
    MOST_FRAMES,
    checked_motion,
    checked_rate,
    is_same_rate,
    joint_columns,
    one_rate,
)
from llsrbm.motion.bodies import body_order
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.robots import Robot

_MOTION = "motion.npz"  # in a folder, or in its zip
_SCENE = "scene.xml"  # beside it
_KEYS = ("qpos", "qvel", "time", "fps", "frequency", "joint_names", "jnt_type", "split_points")
_STATES = {
    "qpos": Quantity((TIME, POSITION), "m, rad", "position, w x y z, joints"),
    "qvel": Quantity((TIME, VELOCITY), "m/s, rad/s", "linear in the world, angular in the base"),
    "time": Quantity((TIME,), "s", "increasing"),
}
_EXPECTED = 'expected an npz file with "qpos", or the folder or zip of an export for MuJoCo'
_RATE = 'a rate as "time", "fps" or "frequency" in the file, or given with it (--fps 500, say)'
_MOST_NAMES = 1000
_FREE = 0  # MuJoCo's number of a free joint's type
_ROOT = 7  # numbers of the root in qpos
_EVEN = 1e-3  # of a step: frames that are that even have a rate


def recognises(path: Path) -> bool:
    """True if it looks like something that `read_motion` reads; opens it, and never raises."""
    try:
        if path.is_dir():
            return (path / _MOTION).is_file() and (path / _SCENE).is_file()
        with open_archive(path, _EXPECTED) as archive:
            # Ours has the same key among others, under a schema.
            alone = "qpos" in archive.keys and "schema" not in archive.keys
            return alone or bool(_motions(archive.names))
    except (OSError, FileFormatError):
        return False


def read_motion(path: Path, robot: Robot, fps: float | None) -> WholeBodyMotion:
    """A motion out of such a folder, its zip, or an npz with `qpos`; raises `FileFormatError`."""
    arrays, where = _arrays(path)
    if "qpos" not in arrays:
        raise FileFormatError(f'{where}: key "qpos" is missing; {_EXPECTED}')
    splits = np.ravel(arrays.get("split_points", np.zeros(0)))
    if len(splits) > 2:
        raise FileFormatError(
            f"{where}: {len(splits) - 1} motions one after the other; expected one"
        )
    states = {key: _STATES[key] for key in _STATES if key in arrays}
    values = checked(arrays, states, where, MOST_FRAMES)
    names = _joint_names(arrays, values["qpos"].shape[1] - _ROOT, robot, where)
    for key, root in (("qpos", _ROOT), ("qvel", _ROOT - 1)):
        if key in values and values[key].shape[1] != root + len(names):
            raise FileFormatError(
                f'{where}: key "{key}": expected {root + len(names)} columns, got '
                f"{values[key].shape[1]}"
            )
    order, found = joint_columns(names, values["qpos"][:, _ROOT:], robot, where)
    ordered = {
        key: values[key][:, [*range(root), *(root + column for column in order)]]
        for key, root in (("qpos", _ROOT), ("qvel", _ROOT - 1))
        if key in values
    }
    time, remarks = _times(arrays, values.get("time"), fps, where)
    qpos, qvel, found = ordered["qpos"], ordered.get("qvel"), (*remarks, *found)
    return checked_motion(robot, "mujoco", where, time, qpos, qvel, remarks=found)


def _arrays(path: Path) -> tuple[Arrays, str]:
    if path.is_dir():
        inner = path / _MOTION
        return read_archive(inner, only=_KEYS, expected=_EXPECTED), str(inner)
    with open_archive(path, _EXPECTED) as archive:
        motions = _motions(archive.names)
        if len(motions) == 1:
            return archive.inner(motions[0]).arrays(_KEYS), f"{path}: {motions[0]}"
        return archive.arrays(_KEYS), str(path)


def _motions(names: Mapping[str, object]) -> list[str]:
    return [
        name
        for name in names
        if PurePosixPath(name).name == _MOTION
        and str(PurePosixPath(name).with_name(_SCENE)) in names
    ]


def _joint_names(arrays: Arrays, count: int, robot: Robot, where: str) -> list[str]:
    """Names of `count` joints: the file's, else those of the robot's model or of its own URDF."""
    if "joint_names" in arrays:
        return _names(arrays, count, where)
    own = body_order(robot, ORDERS[0]).joints
    if count == len(own):
        return list(own)
    # MuJoCo takes its time to import.
    from llsrbm.simulation.scene import joints_in_model_order

    return list(joints_in_model_order(robot))


def _names(arrays: Arrays, count: int, where: str) -> list[str]:
    """The file's names of joints but for the free one, which LocoMuJoCo's files name as well."""
    given = arrays["joint_names"]
    if given.dtype.kind not in "US" or given.ndim != 1 or len(given) > _MOST_NAMES:
        raise FileFormatError(f'{where}: key "joint_names": expected a list of names')
    names = [
        name.decode("utf-8", "replace") if isinstance(name, bytes) else str(name)
        for name in given.tolist()
    ]
    types = np.ravel(arrays.get("jnt_type", np.zeros(0)))
    free = names[:1] if len(types) and types[0] == _FREE else []
    if not free and len(names) == count + 1:
        free = names[:1]
    return names[len(free) :]


def _times(
    arrays: Arrays, time: Array | None, given: float | None, where: str
) -> tuple[float | Array, tuple[str, ...]]:
    """Frames/s, or (K,) s from 0 on if they are not even; and remarks on a rate that was given."""
    rates = [
        checked_rate(arrays[key], f'{where}: key "{key}"')
        for key in ("fps", "frequency")
        if key in arrays
    ]
    requested = None if given is None else checked_rate(given, f"{where}: fps")
    if time is not None and len(time) > 1:
        steps = np.diff(time)
        mean = float(time[-1] - time[0]) / len(steps)
        if not (steps > 0).all():
            raise FileFormatError(f'{where}: key "time": expected seconds that increase')
        if np.abs(steps - mean).max() > _EVEN * mean:
            if rates or requested:
                raise FileFormatError(
                    f"{where}: its frames are not even, by its own times; expected no rate for them"
                )
            return time - time[0], ()
        rates.append(checked_rate(1 / mean, f'{where}: key "time"'))
    for other in rates:
        if not is_same_rate(other, rates[0]):
            raise FileFormatError(
                f"{where}: {rates[0]:g} frames/s by one account, {other:g} by another; expected one"
            )
    rate, remarks = one_rate(rates[0] if rates else None, requested)
    if rate is None:
        raise FileFormatError(f"{where}: it does not say its rate; expected {_RATE}")
    return rate, remarks
