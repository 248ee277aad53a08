"""The tier `table`: a plan sampled beforehand, followed by the motors' own gains."""

import numpy as np

from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.plan import Plan
from llsrbm.motion.whole_body import motion_at
from llsrbm.player.posture import Planned, gains, up_of
from llsrbm.player.tier import PERIOD, PlanTier
from llsrbm.robots import Robot

# s by which rows are sent early: a command is followed about 2 ms later, for a period.
LEAD = 0.003


class Table(PlanTier):
    """Rows of q, dq, tau, a period apart; nothing of the robot's state enters but its clock."""

    name = "table"

    def __init__(self, plan: Plan, robot: Robot) -> None:
        super().__init__(plan, robot)
        self._kp, self._kd = gains(robot)
        self._times = np.arange(0.0, plan.duration + PERIOD, PERIOD)
        motion = motion_at(plan, self._times)
        assert motion.joint_torque is not None  # of plans that converged
        self._q, self._dq, self._tau = (
            motion.joint_position,
            motion.joint_velocity,
            motion.joint_torque,
        )
        self._R = rotation_matrices(motion.base_quat)

    def command(self, time: float, readings: Readings) -> MotorCommand:
        del readings
        row = self._row(time + LEAD)
        if time < 0:
            still = np.zeros_like(self._kp)
            return MotorCommand(self.first.joints, still, self.first.torque, self._kp, self._kd)
        return MotorCommand(self._q[row], self._dq[row], self._tau[row], self._kp, self._kd)

    def planned(self, time: float) -> Planned:
        if time < 0:
            return self.first.planned
        row = self._row(time)
        return Planned(self._q[row], up_of(self._R[row]))

    def _row(self, time: float) -> int:
        return min(max(round(time / PERIOD), 0), len(self._times) - 1)
