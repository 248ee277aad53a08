"""Difference of a plan's turn from the whole body's: what its model leaves out, by Pinocchio.

A plan fixes the angular momentum L, the base's rate and the feet's paths, and they fit each other
by its model. In the whole body they do not: with base and feet as planned it has the momentum
L_body. A robot that has the planned momentum, as the controller sees to, and its feet on their
paths, turns its base faster than planned by

    (L - L_body) / L_1        about the vertical,

L_1 being the body's momentum per rate of the base with the feet at rest in the world: less than the
inertia, as the legs stay behind. During take-off the base gets ahead of a plan whose model has no
momentum of the legs, and falls behind it in flight, where the legs swing on: the two errors have
opposite signs, and a yaw at touchdown is their sum.
"""

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from llsrbm.arrays import Array
from llsrbm.body.joint_loads import speeds_in
from llsrbm.body.knot_motion import KnotMotion, States, arm_rates, states
from llsrbm.body.momentum import momentum_and_inertia
from llsrbm.errors import Error
from llsrbm.mechanics import apply, rotation_matrices
from llsrbm.motion.plan import Plan
from llsrbm.motion.robot import robot_of
from llsrbm.robots.robot import Robot


@dataclass(frozen=True)
class ModelTurn:
    """Yaw (rad) of the whole body beyond the plan's, with the planned momentum and feet."""

    takeoff: float  # at lift-off
    flight: float  # from lift-off to touchdown


_known: WeakKeyDictionary[Plan, ModelTurn | None] = WeakKeyDictionary()


def model_turn(plan: Plan) -> ModelTurn | None:
    """The error of a plan's model; None where it is not known.

    That is of a jump with several flights, or that turns over, where a yaw means little, and where
    the plan's robot is not at hand.
    """
    if plan not in _known:
        _known[plan] = _model_turn(plan)
    return _known[plan]


def _model_turn(plan: Plan) -> ModelTurn | None:
    if len(plan.schedule.flights) != 1 or plan.jump.turns or not plan.solved:
        return None
    try:
        robot = robot_of(plan)
    except Error:
        return None
    if plan.joint_names != robot.joint_names or plan.foot_position.shape[1] != len(robot.legs):
        return None
    try:
        with np.errstate(all="ignore"):  # of a file whose numbers are no motion
            turn = _rate_error(plan, robot) * np.diff(plan.time)
    except np.linalg.LinAlgError:
        return None
    (flight,) = plan.schedule.flights
    phase = plan.phase[:-1]
    return ModelTurn(float(turn[phase < flight].sum()), float(turn[phase == flight].sum()))


def _rate_error(plan: Plan, robot: Robot) -> Array:
    """(N,) rad/s about the vertical, in the middle of each interval."""
    motion = KnotMotion.of_plan(plan)
    _, at = states(robot, motion)
    arms, _ = arm_rates(robot, motion, plan.joint_position)
    position = (plan.joint_position[1:] + plan.joint_position[:-1]) / 2
    still = np.zeros_like(at.com_velocity)
    soles = None if at.foot_omega is None else np.zeros_like(at.foot_omega)
    upright = np.broadcast_to([0.0, 0.0, 1.0], still.shape)
    turning = States(
        at.com, still, at.base_quat, upright, at.foot, np.zeros_like(at.foot), at.foot_quat, soles
    )
    planned = (plan.angular_momentum[1:, 2] + plan.angular_momentum[:-1, 2]) / 2
    inertia = _momentum(robot, position, turning, np.zeros_like(arms))
    return (planned - _momentum(robot, position, at, arms)) / inertia


def _momentum(robot: Robot, position: Array, at: States, arm_speed: Array) -> Array:
    """(N,) kg m2/s, of the whole body about the vertical, with joints (N, J) rad or m."""
    R_world_base = rotation_matrices(at.base_quat)
    speed = speeds_in(robot, position, at, arm_speed)
    rate = apply(np.swapaxes(R_world_base, -1, -2), at.omega)
    momentum, _ = momentum_and_inertia(robot, position, speed, rate)
    return apply(R_world_base, momentum)[:, 2]
