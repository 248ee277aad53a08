"""`Link`: commands to a robot and its readings back, whatever is in between."""

from __future__ import annotations

from abc import ABC, abstractmethod

from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings


class Link(ABC):
    """A connection to one robot, real or simulated."""

    @abstractmethod
    def send(self, command: MotorCommand) -> None:
        """Send a command; it holds until the next one."""

    @abstractmethod
    def receive(self, timeout: float) -> Readings | None:
        """The next reading that was not received yet; None if none arrives within `timeout` s."""

    @abstractmethod
    def close(self) -> None:
        """Stop sending and receiving."""
