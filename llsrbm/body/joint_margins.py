"""How close the realised posture of a whole plan comes to the joints' limits."""

from __future__ import annotations

import numpy as np

from llsrbm.body.postures import JointMargins, joint_speeds, margins
from llsrbm.motion.plan import Plan
from llsrbm.motion.sampling import resample
from llsrbm.robots import Robot

# Both ends and the middle of each interval: feet may change their speed at a knot.
_SHARES = np.array([0.01, 0.5, 0.99])
_STEP = 1e-4  # of an interval


def joint_margins(plan: Plan, robot: Robot) -> JointMargins:
    """Position and speed margins of every joint over the plan, speeds by Jacobians."""
    dt = np.diff(plan.time)[:, None]
    times = (plan.time[:-1, None] + _SHARES * dt).ravel()
    step = np.repeat(_STEP * dt, len(_SHARES))
    before, motion, after = (resample(plan, times + sign * step) for sign in (-1, 0, 1))
    foot_velocity = (after.foot_position - before.foot_position) / (2 * step[:, None, None])
    speeds = joint_speeds(
        robot,
        motion.joint_position,
        motion.base_quat,
        _turn(before.base_quat, after.base_quat) / (2 * step[:, None]),
        motion.com_velocity,
        foot_velocity,
        _turn(before.foot_quat, after.foot_quat) / (2 * step[:, None, None]),
    )
    return margins(robot, times, motion.joint_position, speeds)


def _turn(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Rotation vectors (..., 3) rad, world frame, between attitudes (..., 4) close to each other.

    2 vec(after before*).
    """
    w0, v0 = before[..., :1], before[..., 1:]
    w1, v1 = after[..., :1], after[..., 1:]
    turn: np.ndarray = 2 * (w0 * v1 - w1 * v0 + np.cross(v0, v1))
    return turn
