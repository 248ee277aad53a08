"""A plan in closed form: stand, fly on a parabola turning evenly, stand; legs stiff."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from llsrbm.jump import Jump
from llsrbm.motion.plan import Plan, SolveReport, Violation
from llsrbm.robots import load_robot

GRAVITY = 9.81
STAND, FLY = 0.4, 0.5
KNOTS = 16
TORQUE_SHARE = -0.5


def _com_in_base(robot):
    data = robot.model.createData()
    level = robot.posture.copy()
    level[:3] = 0
    return pin.centerOfMass(robot.model, data, level)


def synthetic_plan(jump: Jump, status: str = "solved") -> Plan:
    robot = load_robot(jump.robot)
    n, legs = 3 * KNOTS + 1, len(robot.legs)
    time = np.concatenate(
        [
            np.linspace(0, STAND, KNOTS, endpoint=False),
            STAND + np.linspace(0, FLY, KNOTS, endpoint=False),
            STAND + FLY + np.linspace(0, STAND, KNOTS + 1),
        ]
    )
    phase = np.repeat([0, 1, 2], [KNOTS, KNOTS, KNOTS + 1])
    flown = np.clip(time - STAND, 0, FLY)
    displacement = np.array([jump.forward, jump.lateral, jump.height])
    velocity = displacement / FLY + [0, 0, 0.5 * GRAVITY * FLY]
    stand_com = robot.base_position + _com_in_base(robot)
    com = stand_com + flown[:, None] * velocity
    com[:, 2] -= 0.5 * GRAVITY * flown**2
    com_velocity = np.where(phase[:, None] == 1, velocity - [[0, 0, GRAVITY]] * flown[:, None], 0.0)
    turn = Rotation.from_euler("z", (jump.twist * flown / FLY)[:, None])
    arm = robot.base_position - stand_com
    base_position = com + turn.apply(arm)
    foot_position = com[:, None] + np.stack(
        [turn.apply(foot - stand_com) for foot in robot.feet], axis=1
    )
    R = turn.as_matrix()
    inertia = R @ robot.inertia @ R.transpose(0, 2, 1)
    rate = np.zeros((n, 3))
    rate[phase == 1, 2] = jump.twist / FLY
    corners = np.einsum("kij,cj->kci", turn.as_matrix(), robot.corners)
    contact_point = (foot_position[:, :, None] + corners[:, None]).reshape(n, -1, 3)
    force = np.zeros_like(contact_point)
    force[phase != 1, :, 2] = robot.mass * GRAVITY / contact_point.shape[1]
    quaternion = turn.as_quat(scalar_first=True)
    quaternion[quaternion[:, 0] < 0] *= -1
    torque = np.where(phase[:, None] != 1, TORQUE_SHARE, 0.0) * robot.torque_limit
    return Plan(
        jump=jump,
        robot_parameters=robot.parameters(),
        report=SolveReport(status, "none", 7, 1, 0.012, 0.013, 0.0, 1.5),
        violations={"friction": Violation(2e-7, "N", "take-off", 0.1)},
        time=time,
        phase=phase.astype(np.int64),
        com=com,
        com_velocity=com_velocity,
        base_quat=quaternion,
        base_position=base_position,
        angular_velocity=rate,
        linear_momentum=robot.mass * com_velocity,
        angular_momentum=np.einsum("kij,kj->ki", inertia, rate),
        inertia=inertia,
        foot_position=foot_position,
        foot_quat=np.tile(
            [1.0, 0, 0, 0] if robot.file.foot.is_point else quaternion[:, None], (1, legs, 1)
        )
        * np.ones((n, 1, 1)),
        contact_point=contact_point,
        contact_force=force,
        leg_mass=np.full(legs, 2.0),
        base_mass=robot.mass - 2.0 * legs,
        leg_com=foot_position * 0.5 + com[:, None] * 0.5,
        joint_position=np.tile(robot.posture[7:], (n, 1)),
        joint_names=robot.joint_names,
        joint_velocity=np.zeros((n, len(robot.joint_names))),
        joint_torque=torque,
        joint_torque_limit=np.tile(robot.torque_limit, (n, 1)),
        foot_in_hip=np.tile(
            robot.mirrors * (robot.feet - robot.base_position - robot.hips), (n, 1, 1)
        ),
    )
