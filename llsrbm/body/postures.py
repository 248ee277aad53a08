"""Postures that realise a plan: inverse kinematics of the whole robot at all knots at once.

The base's attitude is given, so the feet seen from the CoM are given in the base frame too,
beta = R^T (p - r), p a foot's frame: above its contact point, if it is a ball. Unknown are the
joint angles q; they put the base's origin at

    o(q) = -(m_T c_T + sum m_i c_i(q_i)) / m        relative to the CoM, base frame,

and each foot shall be at beta_i = o + f_i(q_i). Newton's step couples the legs through o alone:

    (1 - sum mu_i C_i) do = -sum mu_i C_i e_i,   dq_i = J_i^-1 (e_i - do),

with mu_i = m_i / m, C_i = Jc_i J_i^-1. So the CoM and the attitude are exact in every iterate, and
what a leg cannot reach shows as a foot's residual.

Of soles the attitude is given too: e_i and J_i have three more rows, to which do adds nothing.

Joints of arms are given; where they move, they move the CoM against the base as legs do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from llsrbm.arrays import Array
from llsrbm.errors import InputError
from llsrbm.mechanics import apply, cross, rotation_matrices
from llsrbm.robots.legs import TURN_ARM, LegMotion, damped_inverse, foot_task, shortened
from llsrbm.robots.robot import Robot

_CONVERGED = 1e-7  # m
_REACHED = 1e-5  # m: a knot with a larger residual is tried again from its neighbour
_AS_GOOD = 1e-3  # m: how much more a foot may miss for the sake of continuity
_JUMP = 1.0  # rad between neighbouring knots that hints at another branch of the kinematics
_ITERATIONS = 30
_SOLES_NEED = "{what} is missing: the feet of {robot} are not points; expected it for every foot"


@dataclass(frozen=True, eq=False)
class Postures:
    """The robot's posture at K knots."""

    joint_position: Array  # (K, J) rad or m, in the order of `Robot.joint_names`
    base_position: Array  # (K, 3) m, world frame: origin of the root link
    # (K,) m: largest distance of a foot from where it should be; a sole's wrong turn counts as what
    # it moves a point 0.1 m away.
    residual_m: Array


def solve_postures(
    robot: Robot,
    com: ArrayLike,
    base_quat: ArrayLike,
    foot_position: ArrayLike,
    foot_quat: ArrayLike | None = None,
    q_start: ArrayLike | None = None,
    near: ArrayLike | None = None,
) -> Postures:
    """Joint angles that put the CoM, the base's attitude and every foot where they shall be.

    All knots are solved together, each foot moving from `q_start` along a straight line seen from
    the base, which keeps the legs on one side of their singularities. A knot that fails so, or that
    lies on another branch than the knot before, is solved again from that knot.

    Args:
        robot: the robot.
        com: (K, 3) m, world frame; base_quat: (K, 4) w, x, y, z of the root link.
        foot_position: (K, L, 3) m, world frame, lowest points of feet, middles of soles;
            foot_quat: (K, L, 4), of lines and soles.
        q_start: (nq,) posture to start from, Pinocchio's convention; default: standing. Its arms
            are the postures'.
        near: (K, J) angles close to the postures, to start from instead: a third of the time.

    Returns the postures; where a foot is out of reach, the nearest found and its residual. Raises
    `InputError`: the robot has soles and their attitude is not given.
    """
    r = np.asarray(com, dtype=float)
    p = np.asarray(foot_position, dtype=float) + np.array([0.0, 0.0, robot.foot_lift])
    R_world_base = rotation_matrices(base_quat)
    start = robot.posture if q_start is None else np.asarray(q_start, dtype=float)
    angles = start[None, 7:] if near is None else np.asarray(near, dtype=float)
    joint_position = np.array(np.broadcast_to(angles, (len(r), len(robot.joint_names))))
    # (p - r) @ R is R^T (p - r), a row a foot.
    beta = (p - r[:, None, :]) @ R_world_base
    goal = _Goal(beta, _soles_in_base(robot, R_world_base, foot_quat), joint_position.copy())
    q, residual = _newton(robot, goal, joint_position[:, robot.leg_joint_index])
    _make_continuous(robot, goal, q, residual)
    joint_position[:, robot.leg_joint_index] = q
    com_in_base = robot.chains.motion(q, joints=joint_position).com
    return Postures(joint_position, r - apply(R_world_base, com_in_base), residual)


def joint_speeds(
    robot: Robot,
    joint_position: ArrayLike,
    base_quat: ArrayLike,
    angular_velocity: ArrayLike,
    com_velocity: ArrayLike,
    foot_velocity: ArrayLike,
    foot_angular_velocity: ArrayLike | None = None,
    motion: LegMotion | None = None,
    arm_speed: Array | None = None,
) -> Array:
    """(K, J) joint speeds, rad/s or m/s, by Jacobians; very large next to a singularity.

    Args:
        robot: the robot; joint_position: (K, J) rad or m; base_quat: (K, 4) w, x, y, z.
        angular_velocity: (K, 3) rad/s of the base, world frame, as all others.
        com_velocity: (K, 3) m/s; foot_velocity: (K, L, 3) m/s.
        foot_angular_velocity: (K, L, 3) rad/s of lines and soles; without: `InputError`.
        motion: of the legs at these positions, where it is known.
        arm_speed: (K, A n) rad/s, see `Robot.arm_joint_index`; None: at rest.
    """
    position = np.asarray(joint_position, dtype=float)
    R_world_base = rotation_matrices(base_quat)
    motion = motion or robot.chains.motion(position[:, robot.leg_joint_index], joints=position)
    beta = motion.foot - motion.com[:, None, :]
    omega = apply(np.swapaxes(R_world_base, -1, -2), np.asarray(angular_velocity, dtype=float))
    relative = np.asarray(foot_velocity, dtype=float) - np.asarray(com_velocity)[:, None, :]
    rate = relative @ R_world_base - cross(np.broadcast_to(omega[:, None, :], beta.shape), beta)
    jacobian = motion.foot_jacobian
    if robot.foot_coordinates > 3:
        if foot_angular_velocity is None:
            raise InputError(_SOLES_NEED.format(robot=robot.name, what="foot_angular_velocity"))
        turn = np.asarray(foot_angular_velocity, dtype=float) @ R_world_base - omega[:, None, :]
        rate = np.concatenate([rate, TURN_ARM * turn], axis=-1)
        jacobian = np.concatenate([jacobian, TURN_ARM * motion.foot_turning], axis=-2)
    speeds = np.zeros_like(position)
    carried: Array | float = 0.0
    if arm_speed is not None and robot.arms:
        speeds[:, robot.arm_joint_index] = arm_speed
        carried = apply(motion.com_jacobian_all, speeds)
    speeds[:, robot.leg_joint_index] = _joint_step(
        motion, damped_inverse(jacobian, np.zeros_like(rate)), rate, carried
    )
    return speeds


@dataclass(frozen=True, eq=False)
class _Goal:
    beta: Array  # (K, L, 3) m, seen from the CoM
    rotation: Array | None  # (K, L, 3, 3) R_base_foot of soles, None for points
    joints: Array  # (K, J) rad, of which those of no leg count

    def at(self, knot: int) -> _Goal:
        """One knot's, K = 1."""
        one = slice(knot, knot + 1)
        rotation = None if self.rotation is None else self.rotation[one]
        return _Goal(self.beta[one], rotation, self.joints[one])


def _soles_in_base(robot: Robot, R_world_base: Array, foot_quat: ArrayLike | None) -> Array | None:
    """R_base_foot (K, L, 3, 3) of soles; None for point feet, which have no attitude."""
    if robot.foot_coordinates == 3:
        return None
    if foot_quat is None:
        raise InputError(_SOLES_NEED.format(robot=robot.name, what="foot_quat"))
    R_base_world = np.swapaxes(R_world_base, -1, -2)[:, None]
    return R_base_world @ rotation_matrices(foot_quat)


def _newton(robot: Robot, goal: _Goal, q: Array) -> tuple[Array, Array]:
    """Angles (K, L, n) with the feet at the goal, and residuals (K,) m."""
    q = q.copy()
    motion, error, jacobian = _miss(robot, goal, q)
    for _ in range(_ITERATIONS):
        if np.abs(error).max() < _CONVERGED:
            break
        inverse = damped_inverse(jacobian, error)
        q += _joint_step(motion, inverse, shortened(error))
        motion, error, jacobian = _miss(robot, goal, q)
    return q, np.sqrt(np.sum(error * error, axis=-1)).max(axis=-1)


def _miss(robot: Robot, goal: _Goal, q: Array) -> tuple[LegMotion, Array, Array]:
    """The legs at q, what keeps their feet from the goal and its Jacobian: see `foot_task`."""
    motion = robot.chains.motion(q, rotations=goal.rotation is not None, joints=goal.joints)
    return motion, *foot_task(motion, goal.beta + motion.com[:, None, :], goal.rotation)


def _make_continuous(robot: Robot, goal: _Goal, q: Array, residual: Array) -> None:
    """Solve knots that failed, or lie on another branch, again from the last that is in reach."""
    last: int | None = None
    for k in range(len(q)):
        reached = residual[k] <= _REACHED
        jump = last is not None and np.abs(q[k] - q[last]).max() > _JUMP
        # After a gap of knots out of reach the distance from the last one says nothing.
        if last is not None and (not reached or (jump and last == k - 1)):
            again, again_residual = _newton(robot, goal.at(k), q[last : last + 1])
            nearer = np.abs(again[0] - q[last]).max() < np.abs(q[k] - q[last]).max()
            as_good = again_residual[0] <= (_REACHED if reached else residual[k] + _AS_GOOD)
            if as_good and (nearer or not reached):
                q[k], residual[k] = again[0], again_residual[0]
                reached = residual[k] <= _REACHED
        if reached:
            last = k


def _joint_step(
    motion: LegMotion, inverse: Array, error: Array, by_arms: Array | float = 0.0
) -> Array:
    """Joint step (K, L, n) that moves the feet by `error` (K, L, r) as seen from the CoM.

    `by_arms`: (K, 3) m by which arms move the CoM meanwhile, seen from the base.
    """
    carried = motion.com_jacobian @ inverse
    right = -np.sum(apply(carried, error), axis=1) - by_arms
    moved = np.eye(3) - carried[..., :3].sum(axis=1)
    step = error.copy()
    step[..., :3] -= np.linalg.solve(moved, right[..., None])[..., 0][:, None, :]
    return apply(inverse, step)
