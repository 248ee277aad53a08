"""From the planner's knots to a `Plan`: postures, feet, leg CoMs, everything in the world frame."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from llsrbm.jump import Jump
from llsrbm.planning.knots import Knots
from llsrbm.postures import solve_postures
from llsrbm.robots.robot import Robot
from llsrbm.trajectory.plan import Plan, Solution, SolveReport, Violation


def assemble_plan(
    jump: Jump,
    robot: Robot,
    knots: Knots,
    violations: dict[str, Violation],
    report: Callable[[], SolveReport],
    solution: Solution | None = None,
    near: Plan | None = None,
) -> Plan:
    """The plan of a solution.

    Args:
        jump, robot, knots, violations: what was asked and found.
        report: called last, so that it can count everything.
        solution: what a next solve may start from.
        near: a plan whose postures are close to this one's, so that they are found sooner.
    """
    R = knots.R_world_base
    _, inertia, leg_com = knots.evaluated
    feet = knots.foot_position
    # Knot values of the interval rates: at rest at both ends, the mean in between.
    rate = np.zeros_like(knots.position)
    rate[1:-1] = (knots.rotation_rate[:-1] + knots.rotation_rate[1:]) / 2
    foot_quat = np.zeros((*feet.shape[:2], 4))
    foot_quat[..., 0] = np.cos(knots.foot_heading / 2)
    foot_quat[..., 3] = np.sin(knots.foot_heading / 2)
    angles = None if near is None else near.joint_position
    postures = solve_postures(robot, knots.position, knots.quat, feet, foot_quat, near=angles)
    arrays = {
        "time": knots.time,
        "phase": knots.phase.astype(np.int64),
        "com": knots.position,
        "com_velocity": knots.velocity,
        "base_quat": knots.quat,
        "base_position": postures.base_position,
        "angular_velocity": np.einsum("kij,kj->ki", R, rate),
        "linear_momentum": knots.velocity * knots.task.mass,
        "angular_momentum": knots.momentum,
        "inertia": R @ inertia @ R.transpose(0, 2, 1),
        "foot_position": feet,
        "foot_quat": foot_quat,
        "contact_point": knots.contact_point,
        "contact_force": knots.force,
        "leg_mass": knots.model.leg_mass,
        "leg_com": knots.position[:, None] + np.einsum("kij,klj->kli", R, leg_com),
        "joint_position": postures.joint_position,
        "foot_in_hip": knots.feet_in_hip,
    }
    return Plan(
        jump=jump,
        tuning=knots.task.tuning,
        robot_parameters=robot.parameters(),
        violations=violations,
        base_mass=knots.model.base_mass,
        joint_names=robot.joint_names,
        solution=solution,
        report=report(),
        **arrays,
    )
