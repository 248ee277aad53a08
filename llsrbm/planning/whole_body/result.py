"""A motion of the whole-body problem as a plan."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.body.efforts import efforts
from llsrbm.body.joint_loads import standing_torque
from llsrbm.body.knot_motion import KnotMotion
from llsrbm.body.momentum import centroidal_states
from llsrbm.mechanics import apply, quaternions, rotation_matrices, sign_continuous
from llsrbm.motion.plan import Plan
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.motion import Motion
from llsrbm.planning.whole_body.sizes import NODES
from llsrbm.request.slopes import normals
from llsrbm.robots.drives.torques import torque_in_direction
from llsrbm.robots.feet import foot_contacts
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]


class Feet(NamedTuple):
    """Where feet stand, at the knots of a grid and in the middles between them."""

    place: Array  # (2 N + 1, L, 3) m
    quat: Array  # (2 N + 1, L, 4)
    tilt: Array  # (N + 1, L, 2) gradients of the ground below them, at the knots


def plan_of(motion: Motion, feet: Feet, plan: Plan, robot: Robot, grid: Grid) -> Plan:
    """A plan with the whole body's motion in place of its own, if it has one.

    Its knots are those of the grid and the middles between them: the middles of the plan's
    intervals are the nodes, where its forces and torques are exact.
    """
    time = grid.times(np.concatenate([[0.0], np.cumsum(motion.durations)]))
    at = motion.at(time)
    quat = sign_continuous(at.q[:, [6, 3, 4, 5]])
    R = rotation_matrices(quat)
    joints = at.q[:, 7:]
    com, inertia, momentum, foot_position, foot_rotation, balls = _by_pinocchio(robot, at.q, at.v)
    phase = np.append(np.repeat(grid.phase, len(NODES)), len(grid.phases) - 1)
    rests = _resting(plan.schedule.stands[phase])
    stands, touches = _where_feet_stand(robot, feet, foot_position, balls)
    foot_position = np.where(rests[..., None], stands, foot_position)
    foot_quat = np.where(rests[..., None], feet.quat, _of_soles(robot, foot_rotation))
    corners = rotation_matrices(foot_quat) @ robot.corners.T
    touches = np.where(rests[..., None], touches, foot_position)
    contact_point = touches[:, :, None] + np.swapaxes(corners, -1, -2)

    node_count = grid.intervals * len(NODES)
    interval = np.repeat(np.arange(grid.intervals), len(NODES))
    nodes = motion.within(interval, np.tile(NODES, grid.intervals))
    on = normals(feet.tilt[interval])
    torque = efforts(robot, nodes.q, nodes.v, nodes.a, nodes.force, on)[:, 6:]
    limit = torque_in_direction(robot, nodes.v[:, 6:], torque)
    q_legs = joints[:, robot.leg_joint_index]
    legs_com = robot.chains.masses(q_legs).com
    found = replace(
        plan,
        robot_parameters=robot.parameters(),
        base_mass=plan.base_mass + robot.mass - float(plan.robot_parameters["mass"]),
        time=time,
        phase=phase,
        com=com,
        com_velocity=momentum[:, :3] / robot.mass,
        base_quat=quat,
        base_position=at.q[:, :3],
        angular_velocity=apply(R, at.v[:, 3:6]),
        linear_momentum=momentum[:, :3],
        angular_momentum=momentum[:, 3:],
        inertia=inertia,
        foot_position=foot_position,
        foot_quat=sign_continuous(foot_quat),
        contact_point=contact_point.reshape(len(time), -1, 3),
        contact_force=np.concatenate([nodes.force, np.zeros((1, *nodes.force.shape[1:]))]),
        leg_com=at.q[:, None, :3] + np.einsum("kij,klj->kli", R, legs_com),
        joint_position=joints,
        joint_velocity=at.v[:, 6:],
        joint_names=robot.joint_names,
        joint_torque_limit=np.vstack([limit, robot.torque_limit]),
        foot_in_hip=_in_hips(robot, q_legs, R, foot_rotation),
        feedback_gain=None,  # of the motion that it was
    )
    standing = standing_torque(robot, KnotMotion.of_plan(found), joints[-1])
    return replace(found, joint_torque=np.vstack([torque[:node_count], standing]))


def _where_feet_stand(
    robot: Robot, feet: Feet, foot_position: Array, balls: Array
) -> tuple[Array, Array]:
    """(K, L, 3) m, twice: where feet are that stand, and what of the ground they touch.

    Soles drift by less than the rows' tolerance from where they are planned to stand. Balls roll,
    and frames that are not in their middles rise, sink and lean away from what they touch.
    """
    if not robot.file.foot.is_point:
        return feet.place, feet.place
    tilt, touches = feet.tilt[np.arange(len(foot_position)) // 2], feet.place.copy()
    normal, radius = normals(tilt), foot_contacts(robot)[0].radius
    above = (normal * (balls - feet.place)).sum(axis=-1) - radius
    stands = foot_position - above[..., None] / normal[..., 2:] * [0.0, 0.0, 1.0]
    touches[..., :2] = (balls - radius * normal)[..., :2]
    touches[..., 2] += (tilt * (touches - feet.place)[..., :2]).sum(axis=-1)
    return stands, touches


def _by_pinocchio(
    robot: Robot, q: Array, v: Array
) -> tuple[Array, Array, Array, Array, Array, Array]:
    """CoM, inertia, momentum (linear, angular), the feet's places, attitudes, and lowest balls.

    Places of point feet are their frames', less what these are above their lowest points, standing.
    """
    model, data, legs = robot.model, robot.model.createData(), len(robot.legs)
    com, inertia, momentum = centroidal_states(model, q, v)
    place, rotation = np.empty((len(q), legs, 3)), np.empty((len(q), legs, 3, 3))
    lowest = np.empty((len(q), legs, 3))
    contacts = foot_contacts(robot)
    for k in range(len(q)):
        pin.framesForwardKinematics(model, data, q[k])
        for leg, description in enumerate(robot.legs):
            placed = data.oMf[description.foot_frame_id]
            place[k, leg], rotation[k, leg] = placed.translation, placed.rotation
            balls = placed.rotation @ contacts[leg].centres.T
            lowest[k, leg] = placed.translation + balls[:, balls[2].argmin()]
    place[..., 2] -= robot.foot_lift
    return com, inertia, momentum, place, rotation, lowest


def _of_soles(robot: Robot, rotation: Array) -> Array:
    """(K, L, 4) attitudes of soles; of point feet, which have none, the identity."""
    if len(robot.corners) > 1:
        return quaternions(rotation)
    none = np.zeros((*rotation.shape[:2], 4))
    none[..., 0] = 1.0
    return none


def _in_hips(robot: Robot, q_legs: Array, R: Array, foot_rotation: Array) -> Array:
    """(K, L, 3 or 4) places of feet beside their hips, of soles with their turn, all as if left."""
    places: Array = robot.mirrors * (robot.chains.motion(q_legs).foot - robot.hips)
    if robot.foot_coordinates == 3:
        return places
    across = np.swapaxes(R, -1, -2)[:, None] @ foot_rotation[..., 1:2]
    turned = np.arctan2(-across[..., 0, 0], across[..., 1, 0])
    return np.dstack([places, robot.mirrors[:, 0] * robot.mirrors[:, 1] * turned])


def _resting(stands: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(K, L) whether a foot stands before or after a knot, of (K, L) whether it does after it."""
    before = np.concatenate([stands[:1], stands[:-1]])
    rests: NDArray[np.bool_] = stands | before
    return rests
