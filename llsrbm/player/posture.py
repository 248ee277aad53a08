"""The posture that a plan begins with, and how a robot holds it by its motors alone."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.control.motor_command import MotorCommand
from llsrbm.motion.plan import Plan
from llsrbm.robots import Robot
from llsrbm.simulation.simulate import standing_state
from llsrbm.wire.motor_map import MotorMap
from llsrbm.wire.motors import standing_torque

# Of robots without a table [wire]: a joint that is off by this has its drive's whole torque, rad,
# and s of damping for that stiffness.
STIFF_WITHIN = 0.4
DAMPED_WITHIN = 0.04
# rad/s (m/s) at which a brake gives the drive's whole torque: legs fold within a second.
BRAKES_AT = 10.0


def gains(robot: Robot) -> tuple[Array, Array]:
    """Kp, kd (J,), Nm/rad and Nm s/rad, of the robot's file, with which motors follow a plan."""
    if robot.file.wire is None:
        kp = robot.torque_limit / STIFF_WITHIN
        return kp, DAMPED_WITHIN * kp
    motors = MotorMap.of(robot)
    return motors.kp, motors.kd


def brake(robot: Robot) -> MotorCommand:
    """The command with which a robot is stopped."""
    return MotorCommand.damping(robot.torque_limit / BRAKES_AT)


@dataclass(frozen=True, eq=False)
class Planned:
    """The plan at an instant, as far as a robot can compare itself without knowing where it is."""

    q: Array  # (J,) rad, in `Robot.joint_names`' order
    up: Array  # (3,) the world's z axis in the base's frame


@dataclass(frozen=True, eq=False)
class FirstPosture:
    """The robot standing as a plan begins: q (nq,), Pinocchio's; torque (J,) Nm that it takes."""

    q: Array
    torque: Array

    @classmethod
    def of(cls, plan: Plan, robot: Robot) -> FirstPosture:
        """Raises `InputError`: the robot cannot stand so."""
        q = standing_state(robot, plan)
        return cls(q, standing_torque(robot, q))

    @property
    def joints(self) -> Array:
        """(J,) rad."""
        return self.q[7:]

    @cached_property
    def planned(self) -> Planned:
        """Joints and attitude."""
        return Planned(self.joints, up_of(pin.Quaternion(self.q[3:7]).toRotationMatrix()))


def up_of(R_world_base: Array) -> Array:
    """(3,): the world's z axis in the base's frame."""
    return np.asarray(R_world_base[2])


def up_of_quat(quat: Array) -> Array:
    """Likewise, of (4,) w, x, y, z."""
    w, x, y, z = quat.tolist()
    return np.array([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)])
