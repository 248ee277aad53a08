"""`Link`: commands to a robot and its readings back, whatever is in between."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings


@dataclass(frozen=True)
class Health:
    """A robot's own account of itself: `voltage` of the battery, V; None: not on its wire."""

    voltage: float | None
    charge: float | None  # share, 0 to 1
    hottest: float  # deg C, of the motors


class Link(ABC):
    """A connection to one robot, real or simulated.

    `health`: as of the last reading; None before the first, and of robots that do not tell.
    """

    health: Health | None = None

    @abstractmethod
    def send(self, command: MotorCommand) -> None:
        """Send a command; it holds until the next one."""

    @abstractmethod
    def receive(self, timeout: float) -> Readings | None:
        """The next reading that was not received yet; None if none arrives within `timeout` s."""

    def others(self) -> int:
        """Commands of other programs to the same motors that were heard since the last call."""
        return 0

    @abstractmethod
    def close(self) -> None:
        """Stop sending and receiving."""
