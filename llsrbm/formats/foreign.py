"""From the states in another tool's file to a motion: checked, joints in the robot's order."""

from collections.abc import Sequence, Set
from dataclasses import replace
from typing import Any

import numpy as np

from llsrbm.arrays import Array
from llsrbm.errors import FileFormatError
from llsrbm.formats import plausibility
from llsrbm.motion.bodies import urdf_joints
from llsrbm.motion.sampling import FASTEST
from llsrbm.motion.whole_body import WholeBodyMotion, motion_of_states, velocities
from llsrbm.robots import Robot

MOST_FRAMES = 50_000  # a quarter of an hour at 50 frames/s; a jump has a hundred or two
# What is checked at 1 kHz takes longer than anybody waits for if its time is in ms.
_LONGEST = 1000.0  # s, as `MOST_FRAMES` last at 50 frames/s
_SLOWEST = 1.0  # frames/s; between frames that are further apart nothing of a jump is known
_LARGEST = 1e4  # m, rad, and per s: more is damage, and would overflow in the dynamics
_HELD = 0.01  # rad or m by which a held joint may be elsewhere without a remark
_SAME_RATE = 2e-3  # share by which rates may differ: 60 frames/s, and 59.94
_WAIST = frozenset(("waist_roll_joint", "waist_pitch_joint"))
_WRISTS = {
    axis: frozenset(f"{side}_wrist_{axis}_joint" for side in ("left", "right"))
    for axis in ("roll", "pitch", "yaw")
}
VARIANTS = (_WAIST, _WAIST | _WRISTS["pitch"] | _WRISTS["yaw"])
"""Joints that files of G1 leave out, as Unitree's training code does: 27 are left, or 23."""
WITHOUT_WRISTS = (frozenset[str]().union(*_WRISTS.values()),)
"""Others of 23 have the whole waist and no wrists."""
_UNIT_QUATERNION = 1e-2  # by which a norm may miss 1: single precision, and rounding in files


def checked_rate(value: Any, where: str) -> float:
    """Frames/s; raises `FileFormatError` unless a positive number up to 10000."""
    if isinstance(value, np.ndarray):
        value = value.reshape(-1)[0] if value.size == 1 else f"{value.size} values"
    number = isinstance(value, int | float | np.integer | np.floating)
    if isinstance(value, bool) or not number or not 0 < value <= FASTEST:
        raise FileFormatError(
            f"{where}: expected frames per second, 0 < fps <= {FASTEST:g}, got {value!r:.40}"
        )
    return float(value)


def is_same_rate(one: float, other: float) -> bool:
    """Whether two rates are the same but for how they are rounded."""
    return abs(one - other) <= _SAME_RATE * other


def one_rate(stated: float | None, requested: float | None) -> tuple[float | None, tuple[str, ...]]:
    """The rate that a file states, else the one that is asked for, frames/s; and a remark where
    both are there and differ.
    """
    if stated is None or requested is None or is_same_rate(requested, stated):
        return requested if stated is None else stated, ()
    return stated, (f"it says {stated:g} frames/s: the {requested:g} asked for do not count",)


def joint_orders(
    whole: Sequence[str], robot: Robot, variants: Sequence[Set[str]] = VARIANTS
) -> dict[int, tuple[str, ...]]:
    """Joints of files that do not name them, by their number: those that move, in the order of the
    robot's file, or `whole`, those of the URDF in the format's order, or without a variant's.
    """
    held = set(whole) - set(robot.joint_names)
    fewer = (
        tuple(joint for joint in whole if joint not in missing)
        for missing in variants
        if missing <= held
    )
    return {len(joints): joints for joints in (robot.joint_names, tuple(whole), *fewer)}


def joint_columns(
    names: Sequence[str], position: Array, robot: Robot, where: str
) -> tuple[list[int], tuple[str, ...]]:
    """Where each of `Robot.joint_names` is among the file's `names` (n,), and remarks.

    Joints that the robot holds may be among them; where they are by `position` (K, n), rad or m, is
    left out, with a remark where that is not where the robot holds them. Raises `FileFormatError`:
    other joints or another number of columns.
    """
    known = urdf_joints(robot).joints
    there = set(names)
    if len(there) < len(names) or not set(robot.joint_names) <= there <= set(known):
        listed = " ".join(", ".join(names).split()) or "none"  # one line, whatever the names are
        held = [joint for joint in known if joint not in robot.joint_names]
        also = f", and may have {', '.join(held)}" if held else ""
        raise FileFormatError(
            f"{where}: has joints {listed:.400}, but robot {robot.name} has "
            f"{', '.join(robot.joint_names)}{also}; expected the robot that moves in the file"
        )
    if len(names) != position.shape[1]:
        raise FileFormatError(
            f"{where}: expected a name for each of {position.shape[1]} joints, got {len(names)}"
        )
    return [list(names).index(name) for name in robot.joint_names], _of_held(names, position, robot)


def _of_held(names: Sequence[str], position: Array, robot: Robot) -> tuple[str, ...]:
    off = {
        joint: position[:, list(names).index(joint)] - angle
        for joint, angle in robot.file.urdf.held.items()
        if joint in names
    }
    farthest = {joint: by[np.abs(by).argmax()] for joint, by in off.items()}
    moved = [f"{joint} by up to {by:.2g}" for joint, by in farthest.items() if abs(by) > _HELD]
    if not moved:
        return ()
    more = f" and {len(moved) - 3} more" if len(moved) > 3 else ""
    listed = f"{', '.join(moved[:3])}{more}"
    return (f"Robot {robot.name} holds joints that move ({listed}): they are left out.",)


def checked_motion(
    robot: Robot,
    origin: str,
    where: str,
    time: float | Array,
    qpos: Array,
    qvel: Array | None = None,
    *,
    remarks: Sequence[str] = (),
    w_first: bool = True,
) -> WholeBodyMotion:
    """The motion of which a file has K states, in MuJoCo's convention, joints in the robot's order.

    Args:
        robot, origin, where: the robot, the name of the format, the file (for messages).
        time: frames/s, or (K,) s from 0 on, increasing, of frames that are not evenly spaced.
        qpos: (K, 7 + J); quaternions of either sign.
        qvel: (K, 6 + J); None: by differences (`llsrbm.motion.whole_body.velocities`).
        remarks: on the file, before those on its numbers; w_first: the order of its quaternions.

    Raises:
        FileFormatError: fewer than two frames or too many, a motion that lasts too long, numbers
            that are not finite or are absurd, attitudes that are none.
    """
    count = len(qpos)
    if not 2 <= count <= MOST_FRAMES:
        raise FileFormatError(f"{where}: expected 2 to {MOST_FRAMES} frames, got {count}")
    rate = None if isinstance(time, np.ndarray) else float(time)
    times = time if isinstance(time, np.ndarray) else np.arange(count) / time
    _check_lasts(times, where)
    for values in (qpos,) if qvel is None else (qpos, qvel):
        bad = ~(np.abs(values) <= _LARGEST)  # NaN is not
        if bad.any():
            frame, column = (int(i) for i in np.argwhere(bad)[0])
            raise FileFormatError(
                f"{where}: expected finite numbers up to {_LARGEST:g}, in SI units, got "
                f"{values[frame, column]} in frame {frame}"
            )
    norm = np.linalg.norm(qpos[:, 3:7], axis=1)
    off = np.abs(norm - 1)
    if off.max() > _UNIT_QUATERNION:
        frame = int(np.argmax(off > _UNIT_QUATERNION))
        raise FileFormatError(
            f"{where}: expected unit quaternions, got one of norm {norm[frame]:.4g} in frame "
            f"{frame}; Euler angles and exponential maps are not read"
        )
    raw = qpos
    qpos = np.hstack([qpos[:, :3], qpos[:, 3:7] / norm[:, None], qpos[:, 7:]])
    found = (*remarks, *plausibility.remarks(robot, times, raw, qvel, w_first))
    if qvel is None:
        qvel = velocities(times, qpos)
    return replace(motion_of_states(robot, origin, times, qpos, qvel, rate), remarks=found)


def _check_lasts(time: Array, where: str) -> None:
    """Raise `FileFormatError` of a motion that lasts longer than any that is meant."""
    lasts = float(time[-1] - time[0])
    rate = (len(time) - 1) / lasts
    if lasts > _LONGEST or rate < _SLOWEST:
        raise FileFormatError(
            f"{where}: lasts {lasts:.4g} s with {rate:.3g} frames per second; expected at most "
            f"{_LONGEST:g} s and at least {_SLOWEST:g} frame per second: is its time in ms, or its "
            "rate wrong?"
        )
