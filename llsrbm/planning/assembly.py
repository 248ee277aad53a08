"""From the planner's knots to a `Plan`: postures, feet, leg CoMs, everything in the world frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from llsrbm.analysis.joint_loads import KnotMotion, joint_loads
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
    motion = knot_motion(knots)
    _, inertia, leg_com = knots.evaluated
    # Knot values of the interval rates: at rest at both ends, the mean in between.
    rate = np.zeros_like(knots.position)
    rate[1:-1] = (knots.rotation_rate[:-1] + knots.rotation_rate[1:]) / 2
    angles = None if near is None else near.joint_position
    postures = solve_postures(
        robot, motion.com, motion.base_quat, motion.foot_position, motion.foot_quat, near=angles
    )
    loads = joint_loads(robot, replace(motion, joint_position=postures.joint_position))
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
        "foot_position": motion.foot_position,
        "foot_quat": motion.foot_quat,
        "contact_point": knots.contact_point,
        "contact_force": knots.force,
        "leg_mass": knots.model.leg_mass,
        "leg_com": knots.position[:, None] + np.einsum("kij,klj->kli", R, leg_com),
        "joint_position": postures.joint_position,
        "foot_in_hip": knots.feet_in_hip,
        **loads.at_knots(),
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


def knot_motion(knots: Knots) -> KnotMotion:
    """What `llsrbm.analysis.joint_loads` needs of a solution, without its postures."""
    half = knots.foot_heading / 2
    zero = np.zeros_like(half)
    return KnotMotion(
        time=knots.time,
        phase=knots.phase.astype(np.int64),
        com=knots.position,
        com_velocity=knots.velocity,
        base_quat=knots.quat,
        foot_position=knots.foot_position,
        foot_quat=np.stack([np.cos(half), zero, zero, np.sin(half)], axis=-1),
        contact_point=knots.contact_point,
        contact_force=knots.force,
    )
