"""The tier `closed-loop`: estimator and whole-body controller behind the robot's readings."""

from dataclasses import replace

from llsrbm.control.controller import Tick, WholeBodyController
from llsrbm.control.delay import Measurement
from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.estimation.state_estimator import StateEstimator
from llsrbm.motion.plan import Plan
from llsrbm.player.posture import Planned, up_of
from llsrbm.player.tier import PERIOD, PlanTier
from llsrbm.request.scenario import Scenario
from llsrbm.robots import Robot

DAMPING = 0.01  # share of the drive's torque per rad/s, of motors around the torque they are sent
UNSOLVED = 10  # ticks without a solution, 20 ms, after which the controller has nothing to say


class ClosedLoop(PlanTier):
    """Torques of the whole-body controller, tick by tick, with little damping by the motors.

    Where the robot is comes from its inertial unit, its joints and the feet that the controller
    believes to stand. World frame: the plan's, by where the robot stands as it begins.
    """

    name = "closed-loop"
    # It makes its own torques of the motion, within the drives' limits.
    makes_up_for = frozenset({"dynamics"})

    def __init__(self, plan: Plan, robot: Robot) -> None:
        robot = at_rate(robot, 1 / PERIOD)
        super().__init__(plan, robot)
        self._kd = DAMPING * robot.torque_limit
        self.controller = WholeBodyController(robot, plan, Scenario())
        self._estimator = StateEstimator(robot, self.first.q)
        self.tick: Tick | None = None  # the controller's last decision
        self._unsolved = 0

    def command(self, time: float, readings: Readings) -> MotorCommand:
        self.estimate = q, v = self._estimator.update(readings, self.controller.contacts.carrying)
        self.tick = tick = self.controller.step(Measurement(time, q, v, readings.torque))
        solved = tick.command
        self._unsolved = 0 if solved.solved else self._unsolved + 1
        # What a joint should have reached once the motor follows.
        speed = v[6:] + PERIOD * solved.acceleration[6:]
        return replace(MotorCommand.of_torque(solved.torque), dq=speed, kd=self._kd)

    def planned(self, time: float) -> Planned:
        if self.tick is None:
            return self.first.planned
        target = self.tick.target
        return Planned(target.joint_position, up_of(target.R_world_base))

    @property
    def trouble(self) -> str:
        if self._unsolved < UNSOLVED:
            return ""
        return f"the controller's program was not solved in {self._unsolved} ticks in a row"


def at_rate(robot: Robot, rate: float) -> Robot:
    """The robot with its controller at a rate, Hz."""
    control = robot.file.control.model_copy(update={"rate": rate})
    return replace(robot, file=robot.file.model_copy(update={"control": control}))
