"""Stops and speeds that the controller keeps by itself: in MuJoCo, whose joints have no stops."""

import mujoco
import numpy as np
import pytest

from llsrbm.control import tasks
from llsrbm.control.inverse_dynamics import InverseDynamics
from llsrbm.control.joint_bounds import SPEED, JointBounds
from llsrbm.control.whole_body import WholeBody
from llsrbm.motion.rollout import Disturbance
from llsrbm.robots import load_robot
from llsrbm.robots.drives import torque_range
from llsrbm.simulation.scene import scene_spec
from llsrbm.simulation.surroundings import Surroundings
from tests.llsrbm.control.bodies import resting_target

STEP = 5e-4


def floating(name, position, speed, *, bounded=True, seconds=0.3):
    """Joints (T, J), their speeds (T, J): weightless, drawn to a posture with a speed."""
    robot = load_robot(name)
    spec = scene_spec(robot, Surroundings(-100.0, ()), Disturbance(), STEP)
    spec.option.gravity = np.zeros(3)
    for joint in spec.joints:
        joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
    # Links that meet would stop joints as well.
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    model = spec.compile()
    data = mujoco.MjData(model)
    joints = [model.joint(joint) for joint in robot.joint_names]
    at = [joint.qposadr[0] for joint in joints]
    rate = [joint.dofadr[0] for joint in joints]
    data.qpos[at] = robot.posture[7:]
    data.qpos[3] = 1.0
    body, tick = WholeBody(robot), 1 / robot.file.control.rate
    dynamics, bounds = InverseDynamics(body, 0.5, "quadprog", tick), JointBounds(robot)
    target = resting_target(len(robot.legs), len(at))
    target.joint_position[:], target.joint_velocity[:] = position, speed
    posture = [(tasks.Posture(len(at), (400.0, 40.0)), 1.0)]
    forces = np.zeros((body.contacts, 3))
    positions, speeds = [], []
    for _ in range(round(seconds / tick)):
        q = np.concatenate([data.qpos[:3], data.qpos[[4, 5, 6, 3]], data.qpos[at]])
        R = np.zeros(9)
        mujoco.mju_quat2Mat(R, data.qpos[3:7])
        v = np.concatenate([R.reshape(3, 3).T @ data.qvel[:3], data.qvel[3:6], data.qvel[rate]])
        body.update(q, v)
        body.h -= body.M[:, :3] @ R.reshape(3, 3).T @ [0, 0, 9.81]  # weightless
        command = dynamics.solve(
            posture,
            target,
            np.zeros(body.contacts, dtype=bool),
            forces,
            1.0,
            torque_range(robot, v[6:]),
            bounds.accelerations(body) if bounded else None,
        )
        assert command.solved
        data.ctrl[:] = command.torque
        for _ in range(round(tick / STEP)):
            mujoco.mj_step(model, data)
            positions.append(data.qpos[at].copy())
            speeds.append(data.qvel[rate].copy())
    return np.array(positions), np.array(speeds)


def stops(name):
    model = load_robot(name).model
    return model.lowerPositionLimit[7:], model.upperPositionLimit[7:]


def beyond(name, positions):
    """By how much of their ranges joints are beyond a stop, the farthest."""
    lower, upper = stops(name)
    return (np.maximum(lower - positions, positions - upper) / (upper - lower)).max()


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize(
    ("name", "joint"),
    [("go2", joint) for joint in range(3)] + [(n, j) for n in ("slider", "g1") for j in range(6)],
)
def test_a_task_beyond_a_stop_ends_before_it(name, joint, side):
    lower, upper = stops(name)
    wanted = load_robot(name).posture[7:].copy()
    of_legs = load_robot(name).leg_joint_index[:, joint]
    # One end of its range, and a fifth more.
    wanted[of_legs] = ((lower + upper) / 2 + side * 0.7 * (upper - lower))[of_legs]
    assert beyond(name, floating(name, wanted, 0.0)[0]) < 0.0
    assert beyond(name, floating(name, wanted, 0.0, bounded=False)[0]) > 0.05


@pytest.mark.parametrize("name", ["anymal", "slider"])
def test_a_task_too_fast_for_the_drives_is_followed_at_their_speed(name):
    robot = load_robot(name)
    away = np.sign(np.arange(len(robot.joint_names)) % 2 - 0.5)
    _, speeds = floating(name, robot.posture[7:], 100 * away * robot.speed_limit, seconds=0.05)
    assert (np.abs(speeds) / robot.speed_limit).max() < 1.01 * SPEED


@pytest.mark.parametrize("seed", range(5))
def test_bounds_never_exclude_each_other(seed):
    robot = load_robot("slider")
    body, bounds = WholeBody(robot), JointBounds(robot)
    rng = np.random.default_rng(seed)
    v = 30 * rng.standard_normal(robot.model.nv)
    q = robot.posture.copy()
    q[7:] += rng.standard_normal(len(q) - 7)
    body.update(q, v)
    lower, upper = bounds.accelerations(body)
    assert (lower <= upper).all()
