"""`Tier`: a way to make commands, of a plan or without one."""

from abc import ABC, abstractmethod
from typing import ClassVar

from llsrbm.arrays import Array
from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.motion.plan import Plan
from llsrbm.player.posture import FirstPosture, Planned
from llsrbm.robots import Robot

PERIOD = 0.002  # s between commands, and between readings, on the wires that are known
STANDS = 1.0  # s after the plan's end in which the robot stands, as simulations judge it


class Tier(ABC):
    """Commands for one robot, tick by tick, that begin in the posture `first`.

    Times are s since the start by the robot's clock. Before it, from some tenths of a second on,
    the robot is to be in its first posture.
    """

    name: ClassVar[str]
    # Checks of a certificate that need not hold, as the tier does not follow what they judge.
    makes_up_for: ClassVar[frozenset[str]] = frozenset()

    def __init__(self, robot: Robot, first: FirstPosture) -> None:
        self.robot, self.first = robot, first
        # q (nq,), v (nv,), Pinocchio's, that the last command was made by; None: none is made.
        self.estimate: tuple[Array, Array] | None = None

    @property
    @abstractmethod
    def end(self) -> float:
        """Until when there is something to do, s."""

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


class PlanTier(Tier):
    """A tier that plays a plan; after its end the robot is to stand in the plan's last posture."""

    def __init__(self, plan: Plan, robot: Robot) -> None:
        """Raises `InputError`: the robot cannot stand as the plan begins."""
        super().__init__(robot, FirstPosture.of(plan, robot))
        self.plan = plan

    @property
    def end(self) -> float:
        return self.plan.duration + STANDS
