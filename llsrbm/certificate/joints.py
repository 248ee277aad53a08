"""Checks of the joints: stops, speeds, torques, and torques at their speeds."""

import numpy as np

from llsrbm.certificate.finding import Check
from llsrbm.certificate.sampled_motion import NO_TORQUES, SampledMotion
from llsrbm.robots.drives.torques import FULL_UP_TO


class JointPosition(Check):
    """Joints within the stops of the URDF.

    worst = 1 + e / (upper - lower), e the distance beyond the nearer stop, negative inside, rad or
    m; so 1.01 is one hundredth of the range beyond. `limit` is that stop.
    """

    name, unit = "joint_position", "rad"

    def take(self, motion: SampledMotion) -> None:
        """The joint that comes nearest to a stop, or furthest beyond one."""
        lower, upper = motion.robot.joint_stops
        limited = np.isfinite(upper - lower) & (upper > lower)
        if not limited.any():
            self.nothing("the URDF states no stops")
            return
        q, low, high = motion.joint_position[:, limited], lower[limited], upper[limited]
        beyond = np.maximum(low - q, q - high)
        stop = np.where(low - q > q - high, low, high)
        names = tuple(np.array(motion.robot.joint_names)[limited].tolist())
        self.largest(motion, 1 + beyond / (high - low), stop, names)


class JointSpeed(Check):
    """Joints within the speed of their drives: worst = |v| / v_max.

    Of another tool's motion v is no less than what leads from each frame to the next: velocities of
    frames, which are mostly differences over two intervals, have half of a leap in one.
    """

    name, unit = "joint_speed", "rad/s"

    def take(self, motion: SampledMotion) -> None:
        """The fastest joint."""
        limit = motion.robot.speed_limit
        speed = np.abs(motion.joint_velocity)
        if motion.mean_joint_velocity is not None:
            speed = np.maximum(speed, np.abs(motion.mean_joint_velocity))
        shares = speed / limit
        self.largest(motion, shares, limit, motion.robot.joint_names)


class JointTorque(Check):
    """Joints within the torque of their drives at rest: worst = |tau| / tau_max.

    Of a plan tau is inverse dynamics of the whole body with the planned contact forces; of a
    rollout it is the recorded torque.
    """

    name, unit = "joint_torque", "Nm"

    def take(self, motion: SampledMotion) -> None:
        """The most loaded joint."""
        if motion.torque is None:
            self.unknown(NO_TORQUES)
            return
        limit = motion.robot.torque_limit
        self.largest(motion, np.abs(motion.torque) / limit, limit, motion.robot.joint_names)


class TorqueAtSpeed(Check):
    """Torque and speed together within what the drives can do.

    worst is the factor by which the drive's region of torque and speed would have to grow to hold
    both: with t = |tau| / tau_max, s = |v| / v_max and the share w up to which the whole torque is
    there, max(t, (1 - w) t + s) where the drive drives, t where it brakes. `limit` is the torque
    that it has at that speed.
    """

    name, unit = "torque_at_speed", "Nm"

    def take(self, motion: SampledMotion) -> None:
        """The joint nearest to the end of its drive's region, or furthest beyond."""
        if motion.torque is None:
            self.unknown(NO_TORQUES)
            return
        most, fastest = motion.robot.torque_limit, motion.robot.speed_limit
        t, s = np.abs(motion.torque) / most, np.abs(motion.joint_velocity) / fastest
        drives = motion.torque * motion.joint_velocity > 0
        shares = np.where(drives, np.maximum(t, (1 - FULL_UP_TO) * t + s), t)
        there = np.where(drives, np.clip((1 - s) / (1 - FULL_UP_TO), 0.0, 1.0), 1.0) * most
        self.largest(motion, shares, there, motion.robot.joint_names)
