"""Margins of a plan's postures to the joints' limits of position and speed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from llsrbm.arrays import Array
from llsrbm.body.postures import joint_speeds
from llsrbm.motion.plan import Plan
from llsrbm.motion.sampling import resample
from llsrbm.robots import Robot

# Both ends and the middle of each interval: feet may change their speed at a knot.
_SHARES = np.array([0.01, 0.5, 0.99])
_STEP = 1e-4  # of an interval


@dataclass(frozen=True)
class JointMargin:
    """Margins of one joint to its limits; negative ones are violations."""

    joint: str  # its name
    unit: str  # "rad", or "m" of a sliding joint
    position_margin: float  # rad or m, smallest distance to the URDF's limits
    position_time: float  # s, when
    peak_speed: float  # rad/s or m/s
    speed_margin: float  # the robot file's joint speed minus the peak
    speed_time: float  # s, when the peak is


@dataclass(frozen=True)
class JointMargins:
    """Margins of every joint, in the order of `Robot.joint_names`."""

    joints: tuple[JointMargin, ...]

    def __getitem__(self, joint: str) -> JointMargin:
        return next(margin for margin in self.joints if margin.joint == joint)

    def worst(self) -> str:
        """One sentence on the joints that come closest to their limits."""
        fast = max(self.joints, key=lambda m: m.peak_speed / (m.peak_speed + m.speed_margin))
        near = min(self.joints, key=lambda margin: margin.position_margin)
        speed = (
            f"{fast.joint} is fastest, {fast.peak_speed:.1f} of "
            f"{fast.peak_speed + fast.speed_margin:.1f} {fast.unit}/s at {fast.speed_time:.2f} s"
        )
        side = "beyond" if near.position_margin < 0 else "within"
        room = f"{abs(near.position_margin):.2f} {near.unit}"
        position = (
            f"{near.joint} comes nearest to a stop, {room} {side} its limits "
            f"at {near.position_time:.2f} s"
        )
        return f"{speed}; {position}."


def joint_margins(plan: Plan, robot: Robot) -> JointMargins:
    """Position and speed margins of every joint over the plan.

    Speeds of a draft follow from its feet's by Jacobians; those of a whole body's plan are its own.
    """
    dt = np.diff(plan.time)[:, None]
    times = (plan.time[:-1, None] + _SHARES * dt).ravel()
    if plan.refined:
        own = resample(plan, times)
        assert own.joint_velocity is not None  # files of such plans without it are refused
        return margins(robot, times, own.joint_position, own.joint_velocity)
    step = np.repeat(_STEP * dt, len(_SHARES))
    before, motion, after = (resample(plan, times + sign * step) for sign in (-1, 0, 1))
    foot_velocity = (after.foot_position - before.foot_position) / (2 * step[:, None, None])
    arms = (each.joint_position[:, robot.arm_joint_index] for each in (after, before))
    speeds = joint_speeds(
        robot,
        motion.joint_position,
        motion.base_quat,
        _turn(before.base_quat, after.base_quat) / (2 * step[:, None]),
        motion.com_velocity,
        foot_velocity,
        _turn(before.foot_quat, after.foot_quat) / (2 * step[:, None, None]),
        arm_speed=np.subtract(*arms) / (2 * step[:, None]),
    )
    return margins(robot, times, motion.joint_position, speeds)


def margins(
    robot: Robot, time: ArrayLike, joint_position: ArrayLike, joint_speed: ArrayLike
) -> JointMargins:
    """Margins of each joint to the URDF's position limits and the robot file's speed limit.

    `time`: (K,) s; `joint_position`: (K, J) rad or m; `joint_speed`: (K, J) rad/s or m/s.
    """
    t = np.asarray(time, dtype=float)
    q = np.asarray(joint_position, dtype=float)
    speed = np.abs(np.asarray(joint_speed, dtype=float))
    lower, upper = robot.joint_stops
    room = np.minimum(q - lower, upper - q)
    found = []
    for j, name in enumerate(robot.joint_names):
        tightest, fastest = int(np.argmin(room[:, j])), int(np.argmax(speed[:, j]))
        found.append(
            JointMargin(
                joint=name,
                unit="m" if name in robot.sliding_joints else "rad",
                position_margin=float(room[tightest, j]),
                position_time=float(t[tightest]),
                peak_speed=float(speed[fastest, j]),
                speed_margin=float(robot.speed_limit[j] - speed[fastest, j]),
                speed_time=float(t[fastest]),
            )
        )
    return JointMargins(tuple(found))


def _turn(before: Array, after: Array) -> Array:
    """Rotation vectors (..., 3) rad, world frame, between close attitudes: 2 vec(after before*)."""
    w0, v0 = before[..., :1], before[..., 1:]
    w1, v1 = after[..., :1], after[..., 1:]
    return 2 * (w0 * v1 - w1 * v0 + np.cross(v0, v1))
