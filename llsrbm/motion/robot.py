"""The robot that a motion is of: as its file has it by now, and as the request says it is."""

from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.robots import load_robot
from llsrbm.robots.drives.variants import with_strength
from llsrbm.robots.payload import with_payload
from llsrbm.robots.robot import Robot


def robot_of(motion: Plan | Rollout, name: str | None = None) -> Robot:
    """The robot of a motion with its payload, its drives as strong and as fast as planned with.

    `name`: another robot's name or file, which is to carry the same with such drives.

    Raises:
        InputError: no such robot.
        RobotFileError: its file is wrong.
    """
    limits = (motion if isinstance(motion, Plan) else motion.plan).limits
    strength, battery = (limits.get(name, 1.0) for name in ("drive_strength", "battery"))
    loaded = with_payload(load_robot(name or motion.jump.robot), motion.jump.payload)
    return with_strength(loaded, strength, battery)
