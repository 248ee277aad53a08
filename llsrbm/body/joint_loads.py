"""Speeds and torques of each joint over a plan: the whole body, by Pinocchio.

Nothing of the planner's models enters.

- Speeds at the knots follow from the motion of CoM, base and feet (`llsrbm.body.knot_motion`) by
  Jacobians.
- Accelerations over an interval are the velocities at its end minus those at its start, over its
  length. So they belong to its middle, and no difference is taken across lift-off or touchdown.
- Torques in the middle of an interval are inverse dynamics of the floating base,

      tau = M(q) a + h(q, v) - J^T f + the drives' friction,

  with rotors in M, and the plan's contact forces. The base's linear acceleration is that with
  which the CoM accelerates as planned. The six rows of the base have no drive: their remainder is
  by how much the plan's centroidal dynamics are not those of the whole body.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from llsrbm.arrays import Array, BoolArray, IntArray
from llsrbm.body.efforts import inverse_dynamics
from llsrbm.body.knot_motion import KnotMotion, States, arm_rates, states
from llsrbm.body.postures import Postures, joint_speeds, solve_postures
from llsrbm.mechanics import GRAVITY, apply, cross, rotation_matrices, skew
from llsrbm.request.schedule import Schedule
from llsrbm.robots.drives.torques import friction_torque, torque_in_direction
from llsrbm.robots.robot import Robot

_BASE = 6  # velocities of the floating base
_UPWARD_GRAVITY = np.array([0.0, 0.0, GRAVITY])  # m/s2


@dataclass(frozen=True, eq=False)
class JointLoads:
    """Joint motion and torques in the middle of N intervals, J joints; SI units."""

    time: Array  # (N,) s
    knot_time: Array  # (N+1,) s, where the intervals end
    schedule: Schedule  # which feet stand in a phase
    phase: IntArray  # (N,) of the schedule
    joint_names: tuple[str, ...]  # (J,)
    joint_position: Array  # (N, J) rad or m
    joint_velocity: Array  # (N, J) rad/s or m/s
    joint_torque: Array  # (N, J) Nm or N
    # (N, J) Nm or N, what the drives can give at that speed in the direction of the torque
    # (`llsrbm.robots.drives.torques`).
    torque_available: Array
    # (N, 6) N, Nm: force on the base and moment about its origin, base axes, that the plan lacks;
    # the force is the plan's own balance of linear momentum.
    base_residual: Array
    foot_residual: Array  # (N,) m: what inverse kinematics could not reach
    knot_velocity: Array  # (N+1, J) rad/s or m/s at the knots
    # (N, J) where a leg's foot leaves the ground as the interval ends or has met it as it begins,
    # that knot's velocity, and what is available there for the interval's torque; else NaN.
    edge_velocity: Array
    edge_available: Array
    # (J,) Nm or N: at rest in the last knot's posture, with the smallest contact forces that carry
    # the robot.
    standing_torque: Array
    standing_limit: Array  # (J,) what the drives give at rest

    @property
    def contact(self) -> BoolArray:
        """(N, L) whether a foot stands over an interval."""
        return self.schedule.stands[self.phase]

    def at_knots(self) -> dict[str, Any]:
        """Arrays of a plan at its N + 1 knots; empty where numbers are not finite.

        Of torques and their limits, knot k has those of the interval that starts there, and the
        last knot those of standing.
        """
        arrays = {
            "joint_velocity": self.knot_velocity,
            "joint_torque": np.vstack([self.joint_torque, self.standing_torque]),
            "joint_torque_limit": np.vstack([self.torque_available, self.standing_limit]),
        }
        return arrays if all(np.isfinite(a).all() for a in arrays.values()) else {}


def joint_loads(robot: Robot, motion: KnotMotion) -> JointLoads:
    """Speeds and torques of every joint over a motion; see the module's description.

    Of a motion that is none (time that does not increase, feet out of reach) the numbers are
    meaningless, and may not be finite.
    """
    with np.errstate(all="ignore"):
        return _joint_loads(robot, motion)


def _joint_loads(robot: Robot, motion: KnotMotion) -> JointLoads:
    dt = np.diff(motion.time)[:, None]
    knots, middles = states(robot, motion)
    angles = motion.joint_position
    if angles is None:
        angles = _postures(robot, knots).joint_position
    postures = _postures(robot, middles, near=(angles[1:] + angles[:-1]) / 2)
    position = postures.joint_position
    arms, arms_at_knots = arm_rates(robot, motion, angles)
    knot_velocity = speeds_in(robot, angles, knots, arms_at_knots)
    velocity = speeds_in(robot, position, middles, arms)
    acceleration = np.diff(knot_velocity, axis=0) / dt

    R_base_world = np.swapaxes(rotation_matrices(middles.base_quat), -1, -2)
    effort = _inverse_dynamics(
        robot,
        position,
        velocity,
        acceleration,
        apply(R_base_world, middles.omega),
        apply(R_base_world, np.diff(knots.omega, axis=0) / dt),
        apply(R_base_world, np.diff(motion.com_velocity, axis=0) / dt + _UPWARD_GRAVITY),
    )
    # Where there are forces, the points rest over the interval.
    arm = motion.contact_point[:-1] - postures.base_position[:, None]
    effort -= _contact_effort(
        robot, position, _rows(R_base_world, arm), _rows(R_base_world, motion.contact_force[:-1])
    )
    torque = effort[:, _BASE:] + friction_torque(robot, velocity)
    edge_velocity = _edge_velocity(robot, motion.standing, knot_velocity)
    return JointLoads(
        time=(motion.time[1:] + motion.time[:-1]) / 2,
        knot_time=motion.time,
        schedule=motion.schedule,
        phase=motion.phase[:-1],
        joint_names=robot.joint_names,
        joint_position=position,
        joint_velocity=velocity,
        joint_torque=torque,
        torque_available=torque_in_direction(robot, velocity, torque),
        base_residual=effort[:, :_BASE],
        foot_residual=postures.residual_m,
        knot_velocity=knot_velocity,
        edge_velocity=edge_velocity,
        edge_available=torque_in_direction(robot, edge_velocity, torque),
        standing_torque=standing_torque(robot, motion, angles[-1]),
        standing_limit=robot.torque_limit,
    )


def _postures(robot: Robot, at: States, near: Array | None = None) -> Postures:
    return solve_postures(robot, at.com, at.base_quat, at.foot, at.foot_quat, near=near)


def speeds_in(robot: Robot, joint_position: Array, at: States, arm_speed: Array) -> Array:
    """(K, J) rad/s or m/s of the joints, with the arms' (K, A n), that move base and feet so."""
    return joint_speeds(
        robot,
        joint_position,
        at.base_quat,
        at.omega,
        at.com_velocity,
        at.foot_velocity,
        at.foot_omega,
        arm_speed=arm_speed,
    )


def _edge_velocity(robot: Robot, standing: BoolArray, knot_velocity: Array) -> Array:
    """(N, J), see `JointLoads`; `standing`: (N, L)."""
    edge = np.full((len(standing), knot_velocity.shape[1]), np.nan)
    leaves = np.vstack([standing[:-1] & ~standing[1:], np.zeros_like(standing[:1])])
    lands = np.vstack([np.zeros_like(standing[:1]), ~standing[:-1] & standing[1:]])
    for leg, mine in enumerate(robot.leg_joint_index):
        for intervals, shift in (
            (np.flatnonzero(leaves[:, leg]), 1),
            (np.flatnonzero(lands[:, leg]), 0),
        ):
            edge[np.ix_(intervals, mine)] = knot_velocity[np.ix_(intervals + shift, mine)]
    return edge


# ---- dynamics: efforts (K, 6 + J) of base and joints, base axes


def _inverse_dynamics(
    robot: Robot,
    position: Array,
    velocity: Array,
    acceleration: Array,
    omega: Array,
    omega_rate: Array,
    com_acceleration: Array,
) -> Array:
    """M a + h of joints (K, J) and a turning base (K, 3), given the CoM's acceleration, base axes.

    Gravity acts like a uniform acceleration: both are in the base's linear acceleration, which is
    chosen so that the sum of all forces is m `com_acceleration` (K, 3) m/s2, with gravity's
    reaction.
    """
    count = len(position)
    q = np.tile(np.append(np.zeros(6), 1.0), (count, 1))
    q = np.concatenate([q, position], axis=1)
    v = np.concatenate([np.zeros((count, 3)), omega, velocity], axis=1)
    a = np.concatenate([np.zeros((count, 3)), omega_rate, acceleration], axis=1)
    force = inverse_dynamics(robot.model, q, v, a)[:, :3]
    a[:, :3] = com_acceleration - force / robot.mass
    return inverse_dynamics(robot.model, q, v, a)


def _contact_effort(robot: Robot, position: Array, arm: Array, force: Array) -> Array:
    """J^T f of contact forces (K, C, 3) N at points (K, C, 3) m from the base's origin."""
    count, legs = len(position), len(robot.legs)
    motion = robot.chains.motion(position[:, robot.leg_joint_index])
    on_foot = force.reshape(count, legs, -1, 3)
    from_foot = arm.reshape(on_foot.shape) - motion.foot[:, :, None]
    moment = cross(from_foot, on_foot).sum(axis=2)
    of_legs = apply(np.swapaxes(motion.foot_jacobian, -1, -2), on_foot.sum(axis=2))
    of_legs += apply(np.swapaxes(motion.foot_turning, -1, -2), moment)
    effort = np.zeros((count, _BASE + position.shape[1]))
    effort[:, :3] = force.sum(axis=1)
    effort[:, 3:_BASE] = cross(arm, force).sum(axis=1)
    effort[:, _BASE + robot.leg_joint_index] = of_legs
    return effort


def standing_torque(robot: Robot, motion: KnotMotion, angles: Array) -> Array:
    """(J,) in the last knot's posture, at rest on all contacts."""
    position, rest = angles[None], np.zeros((1, len(angles)))
    R_world_base = rotation_matrices(motion.base_quat[-1])
    still = np.zeros((1, 3))
    up = (_UPWARD_GRAVITY @ R_world_base)[None]
    effort = _inverse_dynamics(robot, position, rest, rest, still, still, up)
    # The feet's places from the base's origin, so that it need not be known in the world.
    legs = robot.chains.motion(position[:, robot.leg_joint_index]).foot[0]
    corners = motion.contact_point[-1].reshape(len(legs), -1, 3) - motion.foot_position[-1][:, None]
    corners = corners - [0.0, 0.0, robot.foot_lift]
    arm = (legs[:, None] + corners @ R_world_base).reshape(-1, 3)
    grasp = np.concatenate([np.tile(np.eye(3), len(arm)), np.concatenate(skew(arm), axis=1)])
    if not np.isfinite(grasp).all():
        return np.full(len(angles), np.nan)
    force = (np.linalg.pinv(grasp) @ effort[0, :_BASE]).reshape(1, -1, 3)
    return (effort - _contact_effort(robot, position, arm[None], force))[0, _BASE:]


def _rows(matrix: Array, vectors: Array) -> Array:
    return vectors @ np.swapaxes(matrix, -1, -2)
