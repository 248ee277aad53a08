"""From the planner's knots to a `Plan`: postures, feet, leg CoMs, everything in the world frame."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.plan import Plan, SolveReport
from llsrbm.ocp.horizon import Iterate
from llsrbm.planning.problem.knots import Knots
from llsrbm.planning.solve.formulation import Attempt
from llsrbm.robots.robot import Robot


def assemble_plan(robot: Robot, attempt: Attempt, report: Callable[[], SolveReport]) -> Plan:
    """The plan of an attempt; `report` is called last, so that it can count everything."""
    task, knots, solution = attempt.task, attempt.knots, attempt.solution
    arrays = knot_arrays(knots) | knots.loads.at_knots()
    return Plan(
        jump=task.jump,
        tuning=task.tuning,
        robot_parameters=robot.parameters(),
        violations=attempt.violations,
        base_mass=knots.model.base_mass,
        joint_names=robot.joint_names,
        schedule=task.schedule,
        obstacle=task.obstacle,
        solution=Iterate(solution.variables, solution.multipliers) if attempt.solved else None,
        report=report(),
        **arrays,
    )


def knot_arrays(knots: Knots) -> dict[str, Any]:
    """Name -> array of what a plan has at its knots, but for the joints' loads."""
    task, R = knots.task, rotation_matrices(knots.quat)
    # Knot values of the interval rates: the mean of both beside it, at rest at the ends, but for
    # those of a run-up, a landing that keeps some speed, and a motion that is under way.
    rate = np.zeros_like(knots.position)
    starts_moving = task.motion is not None or task.start_velocity.any()
    for end, moves in ((0, starts_moving), (-1, task.goal_velocity.any())):
        if moves:
            rate[end] = knots.rotation_rate[end]
    rate[1:-1] = (knots.rotation_rate[:-1] + knots.rotation_rate[1:]) / 2
    return {
        "time": knots.time,
        "phase": knots.phase,
        "com": knots.position,
        "com_velocity": knots.velocity,
        "base_quat": knots.quat,
        "base_position": knots.postures.base_position,
        "angular_velocity": np.einsum("kij,kj->ki", R, rate),
        "linear_momentum": knots.velocity * task.mass,
        "angular_momentum": knots.momentum,
        "inertia": R @ knots.inertia @ R.transpose(0, 2, 1),
        "foot_position": knots.foot_position,
        "foot_quat": knots.foot_quat,
        "contact_point": knots.contact_point,
        "contact_force": knots.force,
        "leg_mass": knots.model.leg_mass,
        "leg_com": knots.position[:, None] + np.einsum("kij,klj->kli", R, knots.leg_com),
        "joint_position": knots.postures.joint_position,
        "foot_in_hip": knots.feet_in_hip,
    }
