"""The drives between a controller and the joints: torques arrive late, and within limits."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from llsrbm.robots.drives import torque_in_direction
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]


class Drives:
    """J drives in the order of `robot.joint_names`."""

    def __init__(self, robot: Robot, delay_ticks: int) -> None:
        self._robot = robot
        self._delay = delay_ticks
        self._under_way: deque[Array] = deque()

    def reset(self) -> None:
        """Forget the torques under way."""
        self._under_way.clear()

    def arriving(self, command: Array) -> Array:
        """(J,) Nm or N: the torque that arrives in the tick in which `command` is sent."""
        if not self._under_way:
            # Before the first tick nothing was sent; the robot was held as it is from then on.
            self._under_way.extend([command] * self._delay)
        self._under_way.append(command)
        return self._under_way.popleft()

    def limited(self, torque: Array, speed: Array) -> tuple[Array, Array]:
        """What is applied of a torque at a speed (J,), and the most there is in its direction."""
        limit = torque_in_direction(self._robot, speed, torque)
        return np.copysign(np.minimum(np.abs(torque), limit), torque), limit
