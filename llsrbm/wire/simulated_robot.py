"""`SimulatedRobot`: a robot in MuJoCo as its wire shows it, with delays, noise and a battery.

It knows neither a wall clock nor a network: time passes tick by tick as it is asked to, the same
for the same seed and commands. `DirectLink` puts a player in front of it in lock-step; the command
`llsrbm robot-sim` puts it behind a robot's own messages.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from llsrbm.arrays import Array
from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.errors import InputError
from llsrbm.motion.rollout import Disturbance
from llsrbm.motion.surroundings import Surroundings
from llsrbm.robots import Robot
from llsrbm.simulation.readings import Instruments
from llsrbm.simulation.scene import hung_posture
from llsrbm.simulation.world import FLAT, TickResult, World, steps_in
from llsrbm.wire.channel import Channel, Faults
from llsrbm.wire.link import Link
from llsrbm.wire.motors import Motors

TICK = 0.002  # s between readings: as Unitree's robots send them
# Share of its voltage that a battery loses a W/kg of the robot, by its inner resistance: Go2's 8
# cells in series (28.8 V, 8 Ah) and G1's 13 (9 Ah), at 12 mOhm a cell with its leads, both come to
# it. A jump takes 60 W/kg for a moment, and has 9 % less speed then.
SAG = 0.0015
LEAST_VOLTAGE = 0.6  # share; below it the electronics of batteries and drives switch off


@dataclass(frozen=True)
class Conditions:
    """Delays and faults between commands and motors, and the battery behind these.

    Attributes:
        delay, delay_spread: s from a command until motors follow it, the same either way; drawn for
            each.
        faults: of the messages, in both directions.
        battery: whether its voltage falls with the power that the drives take.

    Raises `InputError`: a time out of range.
    """

    delay: float = 0.002  # what a bus and a drive's loop take, as measured on small quadrupeds
    delay_spread: float = 0.001
    faults: Faults = field(default_factory=Faults)
    battery: bool = True

    def __post_init__(self) -> None:
        for name in ("delay", "delay_spread"):
            if not 0 <= (value := getattr(self, name)) <= 1:
                raise InputError(f"{name}: expected 0 to 1 s, got {value:g}")


NOMINAL, UNDISTURBED = Conditions(), Disturbance()


@dataclass(frozen=True, eq=False)
class TrueTick:
    """The true course of a tick, for those who judge: no robot knows it."""

    time: float  # s, of its beginning
    state: tuple[Array, Array]  # q (nq,) and v (nv,) at its beginning, Pinocchio's conventions
    mujoco_state: tuple[Array, Array]  # qpos (7 + J,) and qvel (6 + J,), likewise
    result: TickResult  # contacts and torques until its end


class SimulatedRobot:
    """One robot, standing in `posture`, q (nq,), or its default one, until commands arrive.

    `hung`: whether it hangs in its default posture instead; `foot_force`: whether its feet feel
    anything; `observers` are called with each tick. Raises `RobotFileError`: it cannot be
    simulated.
    """

    def __init__(
        self,
        robot: Robot,
        conditions: Conditions = NOMINAL,
        seed: int = 0,
        *,
        surroundings: Surroundings = FLAT,
        disturbance: Disturbance = UNDISTURBED,
        posture: Array | None = None,
        hung: bool = False,
        foot_force: bool = False,
    ) -> None:
        self.robot = robot
        # What the drives take is part of the conditions' delay.
        self.world = World(robot, surroundings, disturbance, TICK, delay=0.0, hung=hung)
        if posture is None:
            posture = hung_posture(robot) if hung else robot.posture
        self.world.reset(posture, np.zeros(robot.model.nv))
        self.observers: list[Callable[[TrueTick], None]] = []
        there, back = (np.random.default_rng([seed, k]) for k in (5, 6))  # apart from all others
        self._commands: Channel[MotorCommand] = Channel(
            conditions.delay, conditions.delay_spread, conditions.faults, there
        )
        # What readings take on a wire is part of the delay of commands.
        self._readings: Channel[Readings] = Channel(0.0, 0.0, conditions.faults, back)
        self._instruments = Instruments(robot, TICK, seed, foot_force=foot_force)
        self._motors = Motors(
            robot, posture, self._instruments.joint_zero, self._commands, TICK / steps_in(TICK)
        )
        self._sag = SAG / self.world.mass if conditions.battery else 0.0
        self._publish(None)

    @property
    def time(self) -> float:
        """By its clock, s."""
        return self.world.time

    @property
    def braking(self) -> bool:
        """True if commands have ceased to come, and motors brake."""
        return self._motors.braking

    @property
    def heard(self) -> int:
        """How many commands its motors have followed."""
        return self._motors.heard

    @property
    def voltage(self) -> float:
        """Voltage of the battery, as a share of that without load."""
        return self.world.drives.voltage

    def send(self, command: MotorCommand, time: float | None = None) -> None:
        """Send a command at a time, s, None: now; motors follow it from when it arrives."""
        self._commands.send(self.time if time is None else time, command)

    def readings(self) -> list[Readings]:
        """The readings that have arrived by now and were not taken yet, the first at time 0."""
        return self._readings.arrived(self.time)

    def tick(self) -> TickResult:
        """Let `TICK` pass. Raises `llsrbm.simulation.world.Diverged`: no more makes sense."""
        time, world = self.time, self.world
        state, mujoco_state = world.state(), (world.qpos, world.qvel)
        result = world.advance(self._motors)
        self._drain(result)
        self._publish(result)
        for observer in self.observers:
            observer(TrueTick(time, state, mujoco_state, result))
        return result

    def advance(self, duration: float) -> None:
        """Let as many ticks pass as are in a time, s; raises as `tick`."""
        for _ in range(round(duration / TICK)):
            self.tick()

    def _drain(self, result: TickResult) -> None:
        """The battery's voltage in the next tick, by the power that the drives gave in this."""
        power = np.maximum(result.torque * self.world.state()[1][6:], 0.0).sum()
        self.world.drives.voltage = max(LEAST_VOLTAGE, 1.0 - self._sag * float(power))

    def _publish(self, last: TickResult | None) -> None:
        readings = self._instruments.read(self.time, self.world.state(), last)
        self._readings.send(self.time, readings)


class DirectLink(Link):
    """A player's link to a simulated robot in its own process: time passes while it receives.

    Of the readings before the link was made it has the last.
    """

    def __init__(self, robot: SimulatedRobot) -> None:
        self._robot = robot
        self._arrived = deque(robot.readings()[-1:])

    def send(self, command: MotorCommand) -> None:
        """Send a command at the moment of the last reading."""
        self._robot.send(command)

    def receive(self, timeout: float) -> Readings | None:
        """The next reading, after as many ticks as it takes, `timeout` s of them at most."""
        until = self._robot.time + timeout
        self._arrived.extend(self._robot.readings())
        while not self._arrived:
            if self._robot.time + TICK > until + TICK / 2:
                return None
            self._robot.tick()
            self._arrived.extend(self._robot.readings())
        return self._arrived.popleft()

    def close(self) -> None:
        """Nothing to do: a robot without commands brakes."""
