"""Legs of a quadruped by where their hips are, for files that know no names."""

from llsrbm.errors import InputError
from llsrbm.robots import Robot
from llsrbm.robots.robot import Leg

_JOINTS = 3  # a leg: abduction, hip, knee


def corner_legs(robot: Robot, format_: str) -> dict[str, Leg]:
    """The legs as "FL", "FR", "RL", "RR", front and rear, left and right. Raises `InputError`: the
    robot has not one leg of three joints at each corner; `format_` is for the message.
    """
    legs = {
        ("F" if hip[0] > 0 else "R") + ("L" if hip[1] > 0 else "R"): leg
        for leg, hip in zip(robot.legs, robot.hips, strict=True)
    }
    joints = {len(leg.joints) for leg in robot.legs}
    if len(robot.legs) != 4 or len(legs) != 4 or joints != {_JOINTS}:
        raise InputError(
            f'format "{format_}": robot {robot.name} is no quadruped; expected one with a leg of '
            f"{_JOINTS} joints at each corner"
        )
    return legs
