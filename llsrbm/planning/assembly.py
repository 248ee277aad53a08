"""From the planner's knots to a `Plan`: postures, feet, leg CoMs, everything in the world frame."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from llsrbm.jump import Jump
from llsrbm.motion.plan import Plan, Solution, SolveReport, Violation
from llsrbm.planning.knots import Knots
from llsrbm.robots.robot import Robot


def assemble_plan(
    jump: Jump,
    robot: Robot,
    knots: Knots,
    violations: dict[str, Violation],
    report: Callable[[], SolveReport],
    solution: Solution | None = None,
) -> Plan:
    """The plan of a solution.

    Args:
        jump, robot, knots, violations: what was asked and found.
        report: called last, so that it can count everything.
        solution: what a next solve may start from.
    """
    R = knots.R_world_base
    _, inertia, leg_com = knots.evaluated
    # Knot values of the interval rates: the mean of both beside it, at rest at the ends.
    rate = np.zeros_like(knots.position)
    for end in (0, -1):
        if knots.velocity[end].any():  # of a run-up, or a landing that keeps some speed
            rate[end] = knots.rotation_rate[end]
    rate[1:-1] = (knots.rotation_rate[:-1] + knots.rotation_rate[1:]) / 2
    arrays = {
        "time": knots.time,
        "phase": knots.phase,
        "com": knots.position,
        "com_velocity": knots.velocity,
        "base_quat": knots.quat,
        "base_position": knots.postures.base_position,
        "angular_velocity": np.einsum("kij,kj->ki", R, rate),
        "linear_momentum": knots.velocity * knots.task.mass,
        "angular_momentum": knots.momentum,
        "inertia": R @ inertia @ R.transpose(0, 2, 1),
        "foot_position": knots.foot_position,
        "foot_quat": knots.foot_quat,
        "contact_point": knots.contact_point,
        "contact_force": knots.force,
        "leg_mass": knots.model.leg_mass,
        "leg_com": knots.position[:, None] + np.einsum("kij,klj->kli", R, leg_com),
        "joint_position": knots.postures.joint_position,
        "foot_in_hip": knots.feet_in_hip,
        **knots.loads.at_knots(),
    }
    return Plan(
        jump=jump,
        tuning=knots.task.tuning,
        robot_parameters=robot.parameters(),
        violations=violations,
        base_mass=knots.model.base_mass,
        joint_names=robot.joint_names,
        solution=solution,
        schedule=knots.task.schedule,
        report=report(),
        **arrays,
    )
