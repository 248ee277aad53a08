"""A request as a plan without a motion, which the whole body's first motion is put into."""

from __future__ import annotations

import numpy as np

from llsrbm.models import free_arms_of
from llsrbm.models.arms import Arms
from llsrbm.motion.plan import Plan
from llsrbm.motion.solve_report import SolveReport
from llsrbm.planning.problem.limits import limits_in
from llsrbm.planning.problem.task import Task
from llsrbm.robots.robot import Robot

FROM_NEARBY = "jumps nearby that were solved before"


def unplanned(task: Task, robot: Robot, solver: str) -> Plan:
    """The plan of a task with no draft: no knots, and no iterations."""
    legs, contacts = len(robot.legs), len(robot.legs) * len(robot.corners)
    lumped = float(robot.chains.mass.mean())
    arms = Arms(robot).mass if free_arms_of(task.jump, robot) else 0.0
    vector, quat = np.zeros((0, 3)), np.zeros((0, 4))
    report = SolveReport(
        status="solved",
        solver=solver,
        iterations=0,
        attempts=0,
        solve_time_s=0.0,
        total_time_s=0.0,
        build_time_s=0.0,
        cost=0.0,
        guess=FROM_NEARBY,
    )
    return Plan(
        jump=task.jump,
        robot_parameters=robot.parameters(),
        report=report,
        violations={},
        schedule=task.schedule,
        obstacle=task.obstacle,
        tuning=task.tuning,
        limits={name: value for name, (_, value) in limits_in(task).items()},
        time=np.zeros(0),
        phase=np.zeros(0, dtype=np.int64),
        com=vector,
        com_velocity=vector,
        base_quat=quat,
        base_position=vector,
        angular_velocity=vector,
        linear_momentum=vector,
        angular_momentum=vector,
        inertia=np.zeros((0, 3, 3)),
        foot_position=np.zeros((0, legs, 3)),
        foot_quat=np.zeros((0, legs, 4)),
        contact_point=np.zeros((0, contacts, 3)),
        contact_force=np.zeros((0, contacts, 3)),
        leg_mass=np.full(legs, lumped),
        base_mass=robot.mass - legs * lumped - arms,
        leg_com=np.zeros((0, legs, 3)),
        joint_position=np.zeros((0, len(robot.joint_names))),
        joint_names=robot.joint_names,
        foot_in_hip=np.zeros((0, legs, robot.foot_coordinates)),
    )
