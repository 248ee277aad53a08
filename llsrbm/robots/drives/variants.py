"""A robot with other drives than its file has: stronger, weaker or ideal ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Any

from llsrbm.errors import InputError
from llsrbm.request.messages import look_up
from llsrbm.robots.drives.table import JointDrives, Losses
from llsrbm.robots.robot import Robot


@lru_cache(maxsize=32)
def with_drives(
    robot: Robot, torque: float = 1.0, speed: float = 1.0, regeneration: float | None = None
) -> Robot:
    """The robot with `torque` and `speed` times its drives' limits; the same object each time.

    `regeneration`: W that each drive takes back at most; None: as the robot's file says.
    """
    changes: dict[str, Any] = {}
    if (torque, speed) != (1.0, 1.0):
        index = robot.leg_joint_index[0]
        legs_alike = all(
            (limit[robot.leg_joint_index] == limit[index]).all()
            for limit in (robot.torque_limit, robot.speed_limit)
        )
        if not legs_alike:
            raise InputError(
                f"{robot.name}: its legs' drives differ in the URDF; expected limits.torque and "
                "limits.joint_speed in the robot file, to scale them"
            )
        changes = {
            "torque": tuple((torque * robot.torque_limit[index]).tolist()),
            "joint_speed": tuple((speed * robot.speed_limit[index]).tolist()),
        }
    if regeneration is not None:
        changes["regeneration"] = regeneration
    if not changes:
        return robot
    limits = robot.file.limits.model_copy(update=changes)
    file = robot.file.model_copy(update={"limits": limits})
    if (torque, speed) != (1.0, 1.0):
        # The name tells the solvers' places in the cache apart.
        name = f"{robot.name}-torque-{torque:g}-speed-{speed:g}"
        file = file.model_copy(update={"name": name})
    other = replace(robot, file=file)
    # What does not change with them: the legs' masses and reach, rotors and friction.
    for name in ("fit", "armature", "friction", "damping"):
        vars(other)[name] = getattr(robot, name)
    return other


@lru_cache(maxsize=32)
def with_strength(robot: Robot, drive_strength: float = 1.0, battery: float = 1.0) -> Robot:
    """The robot whose drives give these shares of the file's torque and speed; the same object each
    time, and where both are 1 that of the file.

    Unlike `with_drives` it is no other robot: its solvers and its numbers in plans are the file's.
    """
    rated = robot.rated or robot
    if (drive_strength, battery) == (1.0, 1.0):
        return rated
    other = replace(rated, drive_strength=drive_strength, battery=battery, rated=rated)
    vars(other)["fit"] = rated.fit
    return other


def driven(robot: Robot, drives: str) -> Robot:
    """The robot with "true" drives, as its file has them, or "ideal" ones.

    Raises `InputError`: another name.
    """
    kinds: dict[str, Callable[[Robot], Robot]] = {"true": lambda same: same, "ideal": ideal}
    return look_up("drives", drives, kinds)(robot)


@lru_cache(maxsize=16)
def ideal(robot: Robot) -> Robot:
    """The robot as if its drives had neither rotors nor friction nor delay, to compare."""
    nothing: dict[str, Any] = dict.fromkeys(("armature", "friction", "damping"), 0.0)
    known = robot.file.drives.known
    drives = JointDrives(
        **nothing, delay=0.0, arms=Losses(**nothing if robot.arms else {}), known=known
    )
    model = robot.model.copy()
    model.armature[:] = 0.0
    rated = None if robot.rated is None else ideal(robot.rated)
    file = robot.file.model_copy(update={"drives": drives})
    other = replace(robot, file=file, model=model, rated=rated)
    vars(other)["fit"] = robot.fit
    return other
