"""Robots as data: one TOML file a robot, everything else computed from its URDF."""

from __future__ import annotations

import os
from pathlib import Path

from llsrbm.errors import InputError
from llsrbm.request.messages import look_up
from llsrbm.robots.build import build_robot
from llsrbm.robots.robot import Leg, Robot
from llsrbm.robots.schema import RobotFile, read_robot_file, robot_files

__all__ = ["Leg", "Robot", "RobotFile", "load_robot", "names", "read_robot_file"]

_KEPT = 16  # robots at most; those that were built first are forgotten first
_Stamp = tuple[tuple[int, int, int], ...]
_kept: dict[str, tuple[_Stamp, Robot]] = {}


def names() -> tuple[str, ...]:
    """Names of the robots that come with the project."""
    return tuple(robot_files())


def load_robot(name_or_path: str) -> Robot:
    """The robot of that name, or of the robot file at that path.

    What ends in ".toml" or contains a path separator is a path. The same object every time, until
    its robot file or its URDF changes on disk: then both are read again.

    Raises:
        InputError: no such name.
        RobotFileError: the file is wrong.
    """
    path = _path(name_or_path)
    key = str(path.absolute())
    kept = _kept.get(key)
    if kept is not None and _stamp(path, *_urdfs(kept[1])) == kept[0]:
        return kept[1]
    # Taken before the file is read: a change meanwhile is then noticed the next time.
    stamp = _stamp(path)
    robot = build_robot(path)
    _kept.pop(key, None)
    _kept[key] = (stamp + _stamp(*_urdfs(robot)), robot)
    for oldest in list(_kept)[:-_KEPT]:
        _kept.pop(oldest, None)
    return robot


def _path(name_or_path: str) -> Path:
    if "\0" in name_or_path:
        raise InputError("robot: expected a name or a path, got one with a null character")
    if name_or_path.endswith(".toml") or os.sep in name_or_path:
        return Path(name_or_path)
    return look_up("robot", name_or_path, robot_files(), "or the path of a robot file (.toml)")


def _urdfs(robot: Robot) -> tuple[Path, Path]:
    return robot.urdf_source, robot.urdf_path


def _stamp(*paths: Path) -> _Stamp:
    return tuple(_state(path) for path in paths)


def _state(path: Path) -> tuple[int, int, int]:
    try:
        status = path.stat()
    except OSError:
        return 0, 0, 0
    return status.st_mtime_ns, status.st_size, status.st_ino
