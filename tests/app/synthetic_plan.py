"""A plan in closed form: stand, fly on a parabola turning evenly, stand; legs stiff.

Of several flights each is like the first; phases between flights share the time of one stance.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from llsrbm.certificate import Certificate, Finding
from llsrbm.motion.plan import Plan
from llsrbm.motion.solve_report import Refinement, SolveReport, Violation
from llsrbm.request.jump import Jump
from llsrbm.request.jump_types import schedule_of
from llsrbm.request.schedule import Schedule
from llsrbm.robots import load_robot

GRAVITY = 9.81
HOLDS = Certificate((Finding("joint_torque", 0.8, 40.0, "Nm", "", 0.3, True, 1.01),))
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
    schedule = schedule_of(jump, robot)
    starts = _starts(schedule)
    n, legs = len(schedule) * KNOTS + 1, len(robot.legs)
    time = np.append(
        np.concatenate([np.linspace(a, b, KNOTS, endpoint=False) for a, b in pairwise(starts)]),
        starts[-1],
    )
    phase = np.append(np.repeat(np.arange(len(schedule)), KNOTS), len(schedule) - 1)
    stands = schedule.stands[phase]
    flies = ~stands.any(axis=1)
    # Of each flight the time flown; their sum says how far it has come, for each is like the first.
    each = [np.clip(time - starts[k], 0, FLY) for k in schedule.flights]
    flown = np.sum(each, axis=0)
    fallen = 0.5 * GRAVITY * np.sum(np.square(each), axis=0)
    since = np.where(flies, flown % FLY, 0.0)  # s, of the flight that goes on
    displacement = np.array([jump.forward, jump.lateral, jump.height])
    velocity = displacement / FLY + [0, 0, 0.5 * GRAVITY * FLY]
    stand_com = robot.base_position + _com_in_base(robot)
    com = stand_com + flown[:, None] * velocity
    com[:, 2] -= fallen
    com_velocity = np.where(flies[:, None], velocity - [[0, 0, GRAVITY]] * since[:, None], 0.0)
    angles = np.outer(flown / FLY, [jump.twist, jump.pitch, jump.roll])
    turn = Rotation.from_euler("ZYX", angles)
    arm = robot.base_position - stand_com
    base_position = com + turn.apply(arm)
    stiff = np.stack([turn.apply(foot - stand_com) for foot in robot.feet], axis=1)
    foot_position = com[:, None] + stiff
    R = turn.as_matrix()
    inertia = R @ robot.inertia @ R.transpose(0, 2, 1)
    rate = np.zeros((n, 3))
    rate[flies, 2] = jump.twist / FLY
    quaternion = turn.as_quat(scalar_first=True)
    quaternion[quaternion[:, 0] < 0] *= -1
    sole = [1.0, 0, 0, 0] if robot.file.foot.is_point else quaternion[:, None]
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
        foot_quat=np.tile(sole, (1, legs, 1)) * np.ones((n, 1, 1)),
        **_contacts(robot, R, foot_position, stands),
        leg_mass=np.full(legs, 2.0),
        base_mass=robot.mass - 2.0 * legs,
        leg_com=foot_position * 0.5 + com[:, None] * 0.5,
        **_stiff_legs(robot, flies),
        schedule=schedule,
    )


def _stiff_legs(robot, flies):
    """What the joints do: nothing but bear a share of their torque where feet stand."""
    n = len(flies)
    return {
        "joint_position": np.tile(robot.posture[7:], (n, 1)),
        "joint_names": robot.joint_names,
        "joint_velocity": np.zeros((n, len(robot.joint_names))),
        "joint_torque": np.where(flies[:, None], 0.0, TORQUE_SHARE) * robot.torque_limit,
        "joint_torque_limit": np.tile(robot.torque_limit, (n, 1)),
        "foot_in_hip": np.tile(
            robot.mirrors * (robot.feet - robot.base_position - robot.hips), (n, 1, 1)
        ),
    }


def _contacts(robot, R, foot_position, stands):
    """Points of contact, which share the weight, and the forces there: (T, C, 3) each."""
    corners = np.einsum("kij,cj->kci", R, robot.corners)
    points = (foot_position[:, :, None] + corners[:, None]).reshape(len(R), -1, 3)
    pushes = np.repeat(stands, len(robot.corners), axis=1)
    share = pushes / np.maximum(pushes.sum(axis=1, keepdims=True), 1)
    force = np.zeros_like(points)
    force[..., 2] = robot.mass * GRAVITY * share
    return {"contact_point": points, "contact_force": force}


def _starts(schedule: Schedule) -> list[float]:
    """s, of each phase, and the end."""
    starts = [0.0]
    for k in range(len(schedule)):
        if k in schedule.flights:
            starts.append(starts[-1] + FLY)
            continue
        following = next((f for f in schedule.flights if f > k), len(schedule))
        before = max((f for f in schedule.flights if f < k), default=-1)
        starts.append(starts[-1] + STAND / (following - before - 1))
    return starts


def refined_plan(plan, status="solved"):
    """As a second stage on the whole body's dynamics leaves it, with a certificate that holds."""
    refinement = Refinement(status, 9, 0.1, 0.1, 0.0, 1.0)
    certificate = HOLDS.as_dict() if status == "solved" else None
    return replace(plan, refinement=refinement, certificate=certificate)
