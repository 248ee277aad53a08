"""`RoundTrip`: how long a command takes until its torque is read back."""

from collections import deque

import numpy as np

from llsrbm.arrays import Array
from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.player.tier import PERIOD
from llsrbm.robots import Robot
from llsrbm.robots.drives.torques import torque_range

LONGEST = 32  # periods that are looked for
# Torque that is added to a joint's to see when it comes back: share of the drive's, and Hz. It is
# six times the noise of such readings, and moves a standing joint by less than a degree.
PROBE, FREQUENCY = 0.03, 12.5


class RoundTrip:
    """Compares the torques that are read with those of the commands before, as `DelayEstimate`.

    Two clocks that were never compared cannot tell how late messages are; the drives can.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._sent: deque[MotorCommand] = deque(maxlen=LONGEST)  # the last one first
        self._misses = np.zeros(LONGEST)

    @property
    def delay(self) -> float:
        """S from a command until the torques that are read are its own, as far as is known."""
        return PERIOD * int(self._misses.argmin())

    def probe(self, since: float) -> Array:
        """(J,) Nm to add to a command's torques, `since` s after the first."""
        wave: float = np.sin(2 * np.pi * FREQUENCY * since)
        return PROBE * wave * self._robot.torque_limit

    def sent(self, command: MotorCommand) -> None:
        """Take note of a command."""
        self._sent.appendleft(command)

    def read(self, readings: Readings) -> None:
        """Take note of readings, before the command that they lead to."""
        if len(self._sent) < LONGEST:
            return
        robot = self._robot
        limits = torque_range(robot, readings.dq)
        wanted = [np.clip(each.torque(readings.q, readings.dq), *limits) for each in self._sent]
        self._misses += (np.abs(readings.torque - wanted) / robot.torque_limit).sum(axis=1)
