"""Robots as data: one TOML file a robot, everything else computed from its URDF."""

from __future__ import annotations

import os
from functools import lru_cache

from llsrbm.errors import InputError
from llsrbm.robots.assets import robot_files
from llsrbm.robots.robot import Leg, Robot, build_robot
from llsrbm.robots.schema import RobotFile, choices, read_robot_file

__all__ = ["Leg", "Robot", "RobotFile", "load_robot", "names", "read_robot_file"]


def names() -> tuple[str, ...]:
    """Names of the robots that come with the project."""
    return tuple(robot_files())


@lru_cache(maxsize=16)
def load_robot(name_or_path: str) -> Robot:
    """The robot of that name, or of the robot file at that path; loaded once a process.

    What ends in ".toml" or contains a path separator is a path.

    Raises:
        InputError: no such name.
        RobotFileError: the file is wrong.
    """
    if name_or_path.endswith(".toml") or os.sep in name_or_path:
        return build_robot(name_or_path)
    files = robot_files()
    if name_or_path not in files:
        raise InputError(
            f'no robot "{name_or_path}"; {choices(name_or_path, files)}, '
            "or the path of a robot file (.toml)"
        )
    return build_robot(files[name_or_path])
