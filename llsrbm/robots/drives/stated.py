"""A robot's drives as stated: their numbers, and which are measured, published or assumed."""

from __future__ import annotations

from typing import Any, get_args

from llsrbm.robots.drives.table import Source
from llsrbm.robots.robot import Robot
from llsrbm.robots.schema import RobotFile

_WORDS = {"armature": "rotors", "friction": "friction", "damping": "damping"}
_ARMS = "arms."  # before the names of what arms have


def known_drives(file: RobotFile) -> dict[str, Source]:
    """How each number of the file's table [drives] is known; what it leaves out is assumed.

    Keys are those of the table, "arms.armature" and so on too where the robot has arms.
    """
    drives = file.drives
    known: dict[str, Source] = {name: getattr(drives.known, name) for name in (*_WORDS, "delay")}
    joints = sum(len(angles) for angles in file.posture.values())
    for name in _WORDS if file.arms else ():
        own = sum(getattr(joint, name) is not None for joint in drives.joints.values())
        stated = getattr(drives.arms, name) is not None or own == joints
        known[_ARMS + name] = known[name] if stated else "assumed"
    return known


def known_in_words(file: RobotFile) -> str:
    """For instance "rotors, friction published; arms' rotors, damping, delay assumed"."""
    words: dict[Source, list[str]] = {source: [] for source in get_args(Source)}
    known = known_drives(file)
    for name, source in known.items():
        of = name.removeprefix(_ARMS)
        if of == name:
            words[source].append(_WORDS.get(name, name))
        elif known[of] != source:  # as the legs' are
            words[source].append(f"arms' {_WORDS[of]}")
    return "; ".join(f"{', '.join(names)} {source}" for source, names in words.items() if names)


def stated_drives(robot: Robot) -> dict[str, Any]:
    """The drives as plain data: lists by joint in SI units, the delay (s), how each is known."""
    return {
        "joints": list(robot.joint_names),
        **{name: getattr(robot, name).tolist() for name in _WORDS},
        "delay": robot.drive_delay,
        "known": known_drives(robot.file),
    }
