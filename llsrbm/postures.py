"""Postures that realise a plan: inverse kinematics of the whole robot at all knots at once.

The base's attitude is given, so the feet seen from the CoM are given in the base frame too,
beta = R^T (p - r). Unknown are the joint angles q; they put the base's origin at

    o(q) = -(m_T c_T + sum m_i c_i(q_i)) / m        relative to the CoM, base frame,

and each foot shall be at beta_i = o + f_i(q_i). Newton's step couples the legs through o alone:

    (1 - sum mu_i C_i) do = -sum mu_i C_i e_i,   dq_i = J_i^-1 (e_i - do),

with mu_i = m_i / m, C_i = Jc_i J_i^-1. So the CoM and the attitude are exact in every iterate, and
what a leg cannot reach shows as a foot's residual.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from llsrbm.robots.legs import (
    LegMotion,
    apply,
    cross,
    damped_inverse,
    rotation_matrices,
    shortened,
)
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

_CONVERGED = 1e-7  # m
_REACHED = 1e-5  # m: a knot with a larger residual is tried again from its neighbour
_AS_GOOD = 1e-3  # m: how much more a foot may miss for the sake of continuity
_JUMP = 1.0  # rad between neighbouring knots that hints at another branch of the kinematics
_ITERATIONS = 30


@dataclass(frozen=True, eq=False)
class Postures:
    """The robot's posture at K knots.

    Attributes:
        joint_position: (K, J) rad or m, in the order of `Robot.joint_names`.
        base_position: (K, 3) m, world frame: origin of the root link.
        residual_m: (K,) m: largest distance of a foot from where it should be.
    """

    joint_position: Array
    base_position: Array
    residual_m: Array


@dataclass(frozen=True)
class JointMargin:
    """How close one joint comes to its limits; negative margins are violations.

    Attributes:
        joint: its name.
        position_margin: rad or m, smallest distance to the URDF's limits.
        position_time: s, when.
        peak_speed: rad/s or m/s.
        speed_margin: the robot file's joint speed minus the peak.
        speed_time: s, when the peak is.
    """

    joint: str
    position_margin: float
    position_time: float
    peak_speed: float
    speed_margin: float
    speed_time: float


@dataclass(frozen=True)
class JointMargins:
    """Margins of every joint, in the order of `Robot.joint_names`."""

    joints: tuple[JointMargin, ...]

    def __getitem__(self, joint: str) -> JointMargin:
        """The margins of the joint of that name."""
        return next(margin for margin in self.joints if margin.joint == joint)

    @property
    def peak_speed(self) -> float:
        """Largest speed of any joint, rad/s or m/s."""
        return max(margin.peak_speed for margin in self.joints)

    @property
    def satisfied(self) -> bool:
        """Whether every joint keeps within its limits."""
        return all(m.position_margin >= 0 and m.speed_margin >= 0 for m in self.joints)

    def worst(self) -> str:
        """One sentence on the joints that come closest to their limits."""
        fast = min(self.joints, key=lambda margin: margin.speed_margin)
        near = min(self.joints, key=lambda margin: margin.position_margin)
        speed = (
            f"{fast.joint} is fastest, {fast.peak_speed:.1f} of "
            f"{fast.peak_speed + fast.speed_margin:.1f} rad/s at {fast.speed_time:.2f} s"
        )
        side = "beyond" if near.position_margin < 0 else "within"
        position = (
            f"{near.joint} comes nearest to a stop, {abs(near.position_margin):.2f} rad {side} "
            f"its limits at {near.position_time:.2f} s"
        )
        return f"{speed}; {position}."


def solve_postures(
    robot: Robot,
    com: ArrayLike,
    base_quat: ArrayLike,
    foot_position: ArrayLike,
    q_start: ArrayLike | None = None,
) -> Postures:
    """Joint angles that put the CoM, the base's attitude and every foot where they shall be.

    All knots are solved together, each foot moving from `q_start` along a straight line seen from
    the base, which keeps the legs on one side of their singularities. A knot that fails so, or that
    lies on another branch than the knot before, is solved again from that knot.

    Args:
        robot: the robot.
        com: (K, 3) m, world frame.
        base_quat: (K, 4) w, x, y, z of the root link.
        foot_position: (K, L, 3) m, world frame.
        q_start: (nq,) posture to start from, Pinocchio's convention; default: standing.

    Returns:
        The postures; where a foot is out of reach, the nearest found and its residual.
    """
    r, p = np.asarray(com, dtype=float), np.asarray(foot_position, dtype=float)
    R_world_base = rotation_matrices(base_quat)
    start = robot.posture if q_start is None else np.asarray(q_start, dtype=float)
    # (p - r) @ R is R^T (p - r), a row a foot.
    beta = (p - r[:, None, :]) @ R_world_base
    first = np.broadcast_to(
        start[7:][robot.leg_joint_index], (len(r), *robot.leg_joint_index.shape)
    )
    q, residual = _newton(robot, beta, first)
    _make_continuous(robot, beta, q, residual)
    joint_position = np.empty((len(r), len(robot.joint_names)))
    joint_position[:, robot.leg_joint_index] = q
    origin = _base_from_com(robot, robot.chains.motion(q).com)
    return Postures(joint_position, r + apply(R_world_base, origin), residual)


def joint_speeds(
    robot: Robot,
    joint_position: ArrayLike,
    base_quat: ArrayLike,
    angular_velocity: ArrayLike,
    com_velocity: ArrayLike,
    foot_velocity: ArrayLike,
) -> Array:
    """Joint speeds that go with a motion, exactly (by Jacobians, not by differences).

    Args:
        robot: the robot.
        joint_position: (K, J) rad or m.
        base_quat: (K, 4) w, x, y, z.
        angular_velocity: (K, 3) rad/s of the base, world frame.
        com_velocity: (K, 3) m/s, world frame.
        foot_velocity: (K, L, 3) m/s, world frame.

    Returns:
        (K, J) rad/s or m/s; very large next to a singularity.
    """
    position = np.asarray(joint_position, dtype=float)
    R_world_base = rotation_matrices(base_quat)
    q = position[:, robot.leg_joint_index]
    motion = robot.chains.motion(q)
    beta = _base_from_com(robot, motion.com)[:, None, :] + motion.foot
    omega = apply(np.swapaxes(R_world_base, -1, -2), np.asarray(angular_velocity, dtype=float))
    relative = np.asarray(foot_velocity, dtype=float) - np.asarray(com_velocity)[:, None, :]
    beta_rate = relative @ R_world_base - cross(
        np.broadcast_to(omega[:, None, :], beta.shape), beta
    )
    speeds = np.empty_like(position)
    speeds[:, robot.leg_joint_index] = _joint_step(
        robot, motion, damped_inverse(motion.foot_jacobian, np.zeros_like(beta)), beta_rate
    )
    return speeds


def margins(
    robot: Robot, time: ArrayLike, joint_position: ArrayLike, joint_speed: ArrayLike
) -> JointMargins:
    """How close each joint comes to the URDF's position limits and the robot file's speed limit.

    Args:
        robot: the robot.
        time: (K,) s.
        joint_position: (K, J) rad or m.
        joint_speed: (K, J) rad/s or m/s, see `joint_speeds`.
    """
    t = np.asarray(time, dtype=float)
    q = np.asarray(joint_position, dtype=float)
    speed = np.abs(np.asarray(joint_speed, dtype=float))
    room = np.minimum(
        q - robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:] - q
    )
    found = []
    for j, name in enumerate(robot.joint_names):
        tightest, fastest = int(np.argmin(room[:, j])), int(np.argmax(speed[:, j]))
        found.append(
            JointMargin(
                joint=name,
                position_margin=float(room[tightest, j]),
                position_time=float(t[tightest]),
                peak_speed=float(speed[fastest, j]),
                speed_margin=float(robot.speed_limit[j] - speed[fastest, j]),
                speed_time=float(t[fastest]),
            )
        )
    return JointMargins(tuple(found))


def _newton(robot: Robot, beta: Array, q: Array) -> tuple[Array, Array]:
    """Angles (K, L, n) with feet at beta (K, L, 3) from the CoM, and residuals (K,) m."""
    q = q.copy()
    for _ in range(_ITERATIONS):
        motion = robot.chains.motion(q)
        error = beta - _base_from_com(robot, motion.com)[:, None, :] - motion.foot
        if np.abs(error).max() < _CONVERGED:
            break
        inverse = damped_inverse(motion.foot_jacobian, error)
        q += _joint_step(robot, motion, inverse, shortened(error))
    motion = robot.chains.motion(q)
    error = beta - _base_from_com(robot, motion.com)[:, None, :] - motion.foot
    return q, np.sqrt(np.sum(error * error, axis=-1)).max(axis=-1)


def _make_continuous(robot: Robot, beta: Array, q: Array, residual: Array) -> None:
    """Solve knots that failed, or lie on another branch, again from the last that is in reach."""
    last: int | None = None
    for k in range(len(q)):
        reached = residual[k] <= _REACHED
        jump = last is not None and np.abs(q[k] - q[last]).max() > _JUMP
        # After a gap of knots out of reach the distance from the last one says nothing.
        if last is not None and (not reached or (jump and last == k - 1)):
            again, again_residual = _newton(robot, beta[k : k + 1], q[last : last + 1])
            nearer = np.abs(again[0] - q[last]).max() < np.abs(q[k] - q[last]).max()
            as_good = again_residual[0] <= (_REACHED if reached else residual[k] + _AS_GOOD)
            if as_good and (nearer or not reached):
                q[k], residual[k] = again[0], again_residual[0]
                reached = residual[k] <= _REACHED
        if reached:
            last = k


def _joint_step(robot: Robot, motion: LegMotion, inverse: Array, error: Array) -> Array:
    """Joint step (K, L, n) that moves the feet by `error` (K, L, 3) as seen from the CoM."""
    fraction = robot.chains.mass / robot.mass
    carried = fraction[:, None, None] * (motion.com_jacobian @ inverse)
    right = -np.sum(apply(carried, error), axis=1)
    base_step = np.linalg.solve(np.eye(3) - carried.sum(axis=1), right[..., None])[..., 0]
    return apply(inverse, error - base_step[:, None, :])


def _base_from_com(robot: Robot, leg_com: Array) -> Array:
    """(K, 3) m: the base's origin relative to the robot's CoM, base frame."""
    trunk = robot.model.inertias[1]
    return -(trunk.mass * trunk.lever + robot.chains.mass @ leg_com) / robot.mass
