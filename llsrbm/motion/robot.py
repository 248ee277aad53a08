"""The robot that a motion is of: as its file has it by now, and as the request says it is."""

from __future__ import annotations

from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.robots import load_robot
from llsrbm.robots.drives.variants import with_strength
from llsrbm.robots.robot import Robot


def robot_of(motion: Plan | Rollout) -> Robot:
    """The robot of a motion, its drives as strong and as fast as the plan took them to be.

    Raises:
        InputError: no such robot.
        RobotFileError: its file is wrong.
    """
    limits = (motion if isinstance(motion, Plan) else motion.plan).limits
    strength, battery = (limits.get(name, 1.0) for name in ("drive_strength", "battery"))
    return with_strength(load_robot(motion.jump.robot), strength, battery)
