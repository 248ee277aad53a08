"""`Tier`: a way to make commands of a plan."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.motion.plan import Plan
from llsrbm.player.posture import FirstPosture, Planned
from llsrbm.robots import Robot

Array = NDArray[np.float64]

PERIOD = 0.002  # s between commands, and between readings, on the wires that are known
STANDS = 1.0  # s after the plan's end in which the robot stands, as simulations judge it


class Tier(ABC):
    """Commands for one plan on one robot, tick by tick.

    Times are s since the plan's start by the robot's clock. Before it, from some tenths of a second
    on, the robot is to stand in the plan's first posture; after its end in the last.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    # Checks of a certificate that need not hold, as the tier does not follow what they judge.
    makes_up_for: ClassVar[frozenset[str]] = frozenset()

    def __init__(self, plan: Plan, robot: Robot) -> None:
        """Raises `InputError`: the robot cannot stand as the plan begins."""
        self.plan, self.robot = plan, robot
        self.first = FirstPosture.of(plan, robot)
        # q (nq,), v (nv,), Pinocchio's, that the last command was made by; None: none is made.
        self.estimate: tuple[Array, Array] | None = None

    @property
    def end(self) -> float:
        """Until when there is something to do, s."""
        return self.plan.duration + STANDS

    @abstractmethod
    def command(self, time: float, readings: Readings) -> MotorCommand:
        """The command for the tick that begins with readings; called with each reading."""

    @abstractmethod
    def planned(self, time: float) -> Planned:
        """The plan at the time of the last command."""

    @property
    def trouble(self) -> str:
        """A reason of the tier's own to stop, in words; "" if there is none."""
        return ""
