"""What a robot's drives can give at a speed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

FULL_UP_TO = 0.7
"""Share of the speed limit up to which the whole torque is there; from there it falls to zero."""


def torque_range(robot: Robot, speed: Array) -> tuple[Array, Array]:
    """Lowest and highest torque, (..., J) each, Nm or N.

    Driving torque falls in a straight line to zero at the speed limit; braking torque does not.

    Args:
        robot: whose file states the limits.
        speed: (..., J) rad/s or m/s, in the order of `Robot.joint_names`.
    """
    torque = robot.torque_limit
    # Called in every step of a simulation: minimum and maximum take a third of clip's time.
    share = speed / ((1.0 - FULL_UP_TO) * robot.speed_limit)
    room = 1.0 / (1.0 - FULL_UP_TO)
    return (
        -torque * np.minimum(np.maximum(room + share, 0.0), 1.0),
        torque * np.minimum(np.maximum(room - share, 0.0), 1.0),
    )


def torque_in_direction(robot: Robot, speed: Array, torque: Array) -> Array:
    """How large a torque can be at a speed in the direction of `torque`, (..., J) Nm or N.

    Args:
        robot, speed: as in `torque_range`.
        torque: (..., J); only its sign counts, zero as positive.
    """
    lowest, highest = torque_range(robot, speed)
    return np.where(torque < 0, -lowest, highest)
