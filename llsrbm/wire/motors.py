"""`Motors`: a robot's motors between the commands of others: they stand, follow, or brake."""

import numpy as np

from llsrbm.arrays import Array
from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.whole_body import WholeBody
from llsrbm.robots import Robot
from llsrbm.wire.channel import Channel

# s without a command until motors brake. Unitree's own do not say; drivers for its A1 took commands
# for lost after as long. Less would brake for a computer's ordinary pauses.
SILENCE = 0.05
# The robot's own controller, before the first command: a joint that is off by this has its drive's
# whole torque against it, rad (m where it slides); and s of damping for that stiffness.
STIFF_WITHIN = 0.2
DAMPED_WITHIN = 0.02


class Motors:
    """The law of a robot's motors: tau + kp (q_d - q) + kd (dq_d - dq) of the command they have.

    `torque` is called once a step of the simulation, `step` s apart. Until the first command
    arrives the robot's own controller holds the joints in `posture`, q (nq,), standing; it does not
    take over again. `zero`: (J,) by which the encoders show too much, which close the loops.
    `braking`: whether the last command is older than `SILENCE`.
    """

    def __init__(
        self,
        robot: Robot,
        posture: Array,
        zero: Array,
        channel: Channel[MotorCommand],
        step: float,
    ) -> None:
        self._zero, self._channel, self._step = zero, channel, step
        kp = robot.torque_limit / STIFF_WITHIN
        kd = DAMPED_WITHIN * kp
        still = np.zeros(len(kp))
        self._command = MotorCommand(posture[7:], still, standing_torque(robot, posture), kp, kd)
        self._brake = MotorCommand.damping(kd)
        self._steps = 0
        self._silent_from = np.inf  # s: when the last command is too old
        self.heard = 0  # commands that have arrived

    @property
    def braking(self) -> bool:
        """True if commands have ceased to come."""
        return self._steps * self._step > self._silent_from

    def torque(self, q: Array, dq: Array) -> Array:
        """Torque (J,) Nm of the next step at true positions (J,) and speeds (J,), not limited."""
        now = self._steps * self._step
        for command in self._channel.arrived(now):
            self._command, self._silent_from = command, now + SILENCE
            self.heard += 1
        self._steps += 1
        follows = self._brake if now > self._silent_from else self._command
        return follows.torque(q + self._zero, dq)


def standing_torque(robot: Robot, q: Array) -> Array:
    """(J,) Nm or N that hold a robot at rest on all feet in q (nq,), their forces alike."""
    body = WholeBody(robot)
    body.update(q, np.zeros(robot.model.nv))
    J = body.contact_jacobian.reshape(-1, robot.model.nv)
    force = np.linalg.lstsq(J[:, :6].T, body.h[:6], rcond=None)[0]
    return (body.h - J.T @ force)[6:]
