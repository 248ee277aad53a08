"""Motor commands at even instants of a plan or a rollout: a robot's table tier, with gains alone.

A row's instant is k / fps. Positions and speeds are the motion's own there. Torques of a plan are
those of inverse dynamics over the interval between knots in which the instant lies (of a refined
plan straight lines through them), those of a rollout what was applied in its tick: feedback
included. At lift-off and touchdown torques jump: a row that falls on such an edge has the torque of
the phase that begins there, so with rows held until the next an edge is late by less than 1 / fps.
Standing still before the motion and after it has the torques of its first and of its last instant.
Gains are those of the robot's file, the same in every row.
"""

from dataclasses import dataclass

import numpy as np

from llsrbm.arrays import Array
from llsrbm.control.motor_command import MotorCommand
from llsrbm.errors import InputError
from llsrbm.motion.trajectory import Trajectory
from llsrbm.motion.whole_body import WholeBodyMotion, whole_body_motion
from llsrbm.robots import Robot
from llsrbm.wire.motor_map import MotorMap


@dataclass(frozen=True, eq=False)
class CommandTable:
    """Commands of J joints, in `Robot.joint_names`' order, at K instants.

    Attributes:
        motion: that they are of; motors: where they go.
        time: (K,) s from 0 on, even.
        q, dq, tau: (K, J) rad, rad/s, Nm (of joints that slide m, m/s, N).
    """

    motion: WholeBodyMotion
    motors: MotorMap
    time: Array
    q: Array
    dq: Array
    tau: Array

    @property
    def robot(self) -> Robot:
        """That is commanded."""
        return self.motion.robot

    @property
    def kp(self) -> Array:
        """(K, J) Nm/rad, N/m."""
        return np.broadcast_to(self.motors.kp, self.q.shape)

    @property
    def kd(self) -> Array:
        """(K, J) Nm s/rad, N s/m."""
        return np.broadcast_to(self.motors.kd, self.q.shape)

    def row(self, k: int) -> MotorCommand:
        """The command of one instant."""
        return MotorCommand(self.q[k], self.dq[k], self.tau[k], self.motors.kp, self.motors.kd)


def command_table(trajectory: Trajectory, fps: float, pad: float = 0.0) -> CommandTable:
    """Sample a plan or a rollout at `fps` rows/s, with `pad` s of standing before and after.

    Raises:
        InputError: a rate or a pad that makes no sense, a plan without torques, a robot without
            [wire] in its file or with other joints by now.
        RobotFileError: the robot is not there.
    """
    motion = whole_body_motion(trajectory, fps, pad)
    if motion.joint_torque is None:
        raise InputError("the plan failed and has no torques; expected one that was solved")
    return CommandTable(
        motion=motion,
        motors=MotorMap.of(motion.robot),
        time=motion.time,
        q=motion.joint_position,
        dq=motion.joint_velocity,
        tau=motion.joint_torque,
    )
