from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from app.motion.baked import bake_plan, presentable
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import synthetic_plan


@pytest.fixture(scope="module")
def robot():
    return load_robot("anymal")


@pytest.fixture(scope="module")
def replay(robot):
    return bake_plan(synthetic_plan(Jump(twist=1.5, forward=0.3, height=0.1)), robot)


def test_bodies_are_where_pinocchio_puts_them(robot, replay):
    data = robot.model.createData()
    for frame in (0, len(replay.motion.time) // 2, -1):
        motion = replay.motion
        q = np.concatenate(
            [
                motion.base_position[frame],
                np.roll(motion.base_quat[frame], -1),
                motion.joint_position[frame],
            ]
        )
        pin.forwardKinematics(robot.model, data, q)
        for body in range(robot.model.njoints - 1):
            expected = data.oMi[body + 1]
            R = Rotation.from_quat(
                replay.frames.body_wxyz[frame, body], scalar_first=True
            ).as_matrix()
            assert replay.frames.body_position[frame, body] == pytest.approx(expected.translation)
            assert pytest.approx(expected.rotation, abs=1e-9) == R


def test_a_stiff_robot_has_equal_ellipsoids(replay):
    assert replay.frames.inertia_axes == pytest.approx(
        np.broadcast_to(replay.rigid_axes, replay.frames.inertia_axes.shape)
    )
    same = np.abs(np.sum(replay.frames.inertia_wxyz * replay.rigid_wxyz, axis=1))
    assert same == pytest.approx(1.0)


@pytest.mark.parametrize("broken", ["com", "base_quat", "inertia", "joint_position"])
def test_a_diverged_plan_is_not_drawn(broken):
    plan = synthetic_plan(Jump())
    assert presentable(plan)
    values = getattr(plan, broken).copy()
    values[3] = np.nan
    assert not presentable(replace(plan, **{broken: values}))


def test_a_plan_whose_time_stands_still_is_not_drawn():
    plan = synthetic_plan(Jump())
    time = plan.time.copy()
    time[4] = time[3]
    assert not presentable(replace(plan, time=time))
