"""From the states in a foreign file to a motion: checked, in the robot's order, with velocities."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.errors import FileFormatError
from llsrbm.mechanics import rotation_matrices, sign_continuous
from llsrbm.motion.derivatives import velocities as differences
from llsrbm.motion.instants import FASTEST
from llsrbm.motion.whole_body import WholeBodyMotion, motion_of_states
from llsrbm.robots import Robot

Array = NDArray[np.float64]
Velocities = tuple[Array, Array, Array]

MOST_FRAMES = 50_000  # a quarter of an hour at 50 frames/s; a jump has a hundred or two
_LARGEST = 1e4  # m, rad, and per s: more is damage, and would overflow in the dynamics
_UNIT_QUATERNION = 1e-3  # largest deviation of a norm from 1 that still is an attitude


def checked_rate(value: Any, where: str) -> float:
    """Frames/s.

    Raises:
        FileFormatError: it is no positive number up to 10000.
    """
    number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not number or not 0 < value <= FASTEST:
        raise FileFormatError(
            f"{where}: expected frames per second, 0 < fps <= {FASTEST:g}, got {value!r:.40}"
        )
    return float(value)


def joint_columns(names: Sequence[str], robot: Robot, where: str) -> list[int]:
    """Where each of `Robot.joint_names` is among the file's.

    Raises:
        FileFormatError: they are not the robot's joints.
    """
    if sorted(names) != sorted(robot.joint_names):
        listed = " ".join(", ".join(names).split())  # one line, whatever the names are
        raise FileFormatError(
            f"{where}: has joints {listed:.400}, but robot {robot.name} has "
            f"{', '.join(robot.joint_names)}; expected the robot that moves in the file"
        )
    return [list(names).index(name) for name in robot.joint_names]


def checked_motion(
    robot: Robot,
    origin: str,
    where: str,
    fps: float,
    base_position: Array,
    base_quat: Array,
    joint_position: Array,
    velocities: Velocities | None = None,
) -> WholeBodyMotion:
    """The motion of which a file has K states; world frame.

    Args:
        robot: that moves.
        origin: the name of the format.
        where: the file, for messages.
        fps: frames/s.
        base_position: (K, 3) m; base_quat: (K, 4) w, x, y, z: root link.
        joint_position: (K, J) rad or m, in the robot's order.
        velocities: (K, 3) m/s of the root link's origin and (K, 3) rad/s of the root link, world
            axes, and (K, J) of the joints; None: by differences (`llsrbm.motion.derivatives`).

    Raises:
        FileFormatError: fewer than two frames or too many, numbers that are not finite or are
            absurd, attitudes that are none.
    """
    count = len(base_position)
    if not 2 <= count <= MOST_FRAMES:
        raise FileFormatError(f"{where}: expected 2 to {MOST_FRAMES} frames, got {count}")
    for values in (base_position, base_quat, joint_position, *(velocities or ())):
        bad = ~(np.abs(values) <= _LARGEST)  # NaN is not
        if bad.any():
            frame, column = (int(i) for i in np.argwhere(bad)[0])
            raise FileFormatError(
                f"{where}: expected finite numbers up to {_LARGEST:g}, got "
                f"{values[frame, column]} in frame {frame}"
            )
    norm = np.linalg.norm(base_quat, axis=1)
    off = np.abs(norm - 1) > _UNIT_QUATERNION
    if off.any():
        frame = int(np.argmax(off))
        raise FileFormatError(
            f"{where}: expected unit quaternions, got one of norm {norm[frame]:.4g} in frame "
            f"{frame}"
        )
    quat = sign_continuous(base_quat / norm[:, None])
    time = np.arange(count) / fps
    qpos = np.hstack([base_position, quat, joint_position])
    if velocities is None:
        qvel = differences(time, qpos)
    else:
        velocity, angular_velocity, joint_velocity = velocities
        in_base = np.einsum("kji,kj->ki", rotation_matrices(quat), angular_velocity)
        qvel = np.hstack([velocity, in_base, joint_velocity])
    return motion_of_states(robot, origin, time, qpos, qvel, fps)
