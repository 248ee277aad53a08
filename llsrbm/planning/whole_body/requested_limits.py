"""Limits of a request that no row of the whole body's problem has, measured in its motion.

Reach, the feet's speed and turn, and the distance of front from hind feet are rows of drafts
alone. A motion that goes beyond the limits that a request sets says by how much.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.body.momentum import base_velocities
from llsrbm.mechanics import apply, rotation_matrices
from llsrbm.motion.plan import Plan
from llsrbm.motion.solve_report import Violation
from llsrbm.planning.problem.task import Task
from llsrbm.robots.robot import Robot

_ALIGNED = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


def limit_violations(plan: Plan, task: Task, robot: Robot) -> dict[str, Violation]:
    """Constraint, by its name in drafts, -> the largest violation of its limits in the request.

    `plan`: of the whole body; `task`: under its limits. Constraints without such limits are
    left out.
    """
    worst: dict[str, Violation] = {}
    for name, unit, amount in _amounts(plan, task, robot):
        knot = int(np.argmax(amount))
        found = Violation(
            amount=max(0.0, float(amount[knot])),
            unit=unit,
            phase=plan.schedule.names[int(plan.phase[knot])],
            time=float(plan.time[knot]),
        )
        if name not in worst or found.amount > worst[name].amount:
            worst[name] = found
    return worst


def _amounts(plan: Plan, task: Task, robot: Robot) -> Iterator[tuple[str, str, Array]]:
    """Names, units, and (K,) by how much the knots are beyond a limit; negative within."""
    requested, reach = plan.tuning.limits, task.reach
    x = plan.foot_in_hip[..., :3]
    # Both ends are as the robot stands.
    free = np.isin(np.arange(len(plan.time)), (0, len(plan.time) - 1), invert=True)

    def most(beyond: Array) -> Array:
        return np.where(free, beyond.reshape(len(free), -1).max(axis=1), -np.inf)

    distance = np.linalg.norm(x, axis=-1)
    of_reach = {
        "reach_min": reach.distance[0] - distance,
        "reach_max": distance - reach.distance[1],
    }
    for axis, letter in enumerate("xyz"):
        of_reach[f"reach_{letter}_min"] = reach.lower[axis] - x[..., axis]
        of_reach[f"reach_{letter}_max"] = x[..., axis] - reach.upper[axis]
    of_reach["reach_standing"] = np.where(plan.contact, x[..., 2] + task.lowest_hips, -np.inf)
    yield from (("reach", "m", most(of_reach[name])) for name in of_reach.keys() & requested.keys())
    if "foot_speed" in requested:
        yield "foot_speed", "m/s", most(np.abs(_speeds(plan, robot)) - task.limits.foot_speed)
    if "stop_margin" in requested:
        order = [plan.joint_names.index(name) for name in robot.joint_names]
        q, (low, high) = (
            plan.joint_position[:, order],
            robot.stops_kept_by(requested["stop_margin"]),
        )
        yield "joint_stops", "rad", most(np.maximum(low - q, q - high))
    if "feet_apart" in requested:
        feet = (np.array(robot.hips) + np.array(robot.mirrors) * x)[..., :2]
        for one, other in combinations(range(feet.shape[1]), 2):
            flies = ~(plan.contact[:, one] & plan.contact[:, other])
            apart = np.linalg.norm(feet[:, one] - feet[:, other], axis=-1)
            near = np.where(flies, task.limits.feet_apart - apart, -np.inf)
            yield "feet_apart", "m", most(near)
    if robot.foot_coordinates > 3:
        low, high = task.foot.yaw
        turn = plan.foot_in_hip[..., 3]
        ends = {"foot_yaw_min": low - turn, "foot_yaw_max": turn - high}
        yield from (
            ("foot_yaw", "rad", most(ends[name])) for name in ends.keys() & requested.keys()
        )


def _speeds(plan: Plan, robot: Robot) -> Array:
    """(K, L, 3) m/s of the feet's frames in the world, along the base's axes."""
    assert plan.joint_velocity is not None  # a whole body's plan has it
    order = [plan.joint_names.index(name) for name in robot.joint_names]
    R_world_base = rotation_matrices(plan.base_quat)
    rate = apply(np.swapaxes(R_world_base, -1, -2), plan.angular_velocity)
    q, v = plan.joint_position[:, order], plan.joint_velocity[:, order]
    base = plan.base_position, plan.base_quat, rate
    moves = base_velocities(robot, plan.com_velocity, *base, q, v)
    model, data = robot.model, robot.model.createData()
    found = np.empty(plan.foot_position.shape)
    for k, R in enumerate(R_world_base):
        at = np.concatenate([plan.base_position[k], np.roll(plan.base_quat[k], -1), q[k]])
        pin.forwardKinematics(model, data, at, np.concatenate([R.T @ moves[k], rate[k], v[k]]))
        for i, leg in enumerate(robot.legs):
            speed = pin.getFrameVelocity(model, data, leg.foot_frame_id, _ALIGNED)
            found[k, i] = R.T @ speed.linear
    return found
