from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from app.frames import ellipsoid
from app.replay import bake, presentable
from llsrbm.jump import Jump
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import synthetic_plan


@pytest.fixture(scope="module")
def robot():
    return load_robot("anymal")


@pytest.fixture(scope="module")
def replay(robot):
    return bake(synthetic_plan(Jump(twist=1.5, forward=0.3, height=0.1)), robot)


def solid_inertia(axes, wxyz, mass):
    """Inertia of a uniform solid ellipsoid, from points drawn on a grid inside it."""
    R = Rotation.from_quat(wxyz, scalar_first=True).as_matrix()
    grid = np.linspace(-1, 1, 61)
    ball = np.stack(np.meshgrid(grid, grid, grid), axis=-1).reshape(-1, 3)
    points = (ball[np.linalg.norm(ball, axis=1) <= 1] * axes) @ R.T
    second = points.T @ points / len(points)
    return mass * (np.trace(second) * np.eye(3) - second)


def test_the_ellipsoid_has_the_inertia_it_is_drawn_for(robot):
    turn = Rotation.from_euler("zyx", [0.7, 0.2, -0.4]).as_matrix()
    inertia = turn @ robot.inertia @ turn.T
    axes, wxyz = ellipsoid(inertia[None], robot.mass, turn[None])
    assert solid_inertia(axes[0], wxyz[0], robot.mass) == pytest.approx(inertia, rel=0.01, abs=0.01)


@given(arrays(float, 3, elements=st.floats(-3, 3)), st.permutations([0.9, 1.1, 1.3]))
def test_the_ellipsoid_turns_with_its_reference(rotation_vector, moments):
    """Axis i stays near the reference's axis i, whichever moment is the largest."""
    turn = Rotation.from_rotvec(rotation_vector)
    R = turn.as_matrix()
    _, wxyz = ellipsoid((R @ np.diag(moments) @ R.T)[None], 30.0, R[None])
    apart = turn.inv() * Rotation.from_quat(wxyz[0], scalar_first=True)
    assert apart.magnitude() < 1e-6


def test_the_ellipsoid_does_not_jump_where_moments_cross():
    share = np.linspace(0, 1, 100)[:, None, None]
    inertia = (1 - share) * np.diag([1.0, 1.1, 1.4]) + share * np.diag([1.2, 1.0, 1.4])
    inertia[:, 0, 2] = inertia[:, 2, 0] = 0.05
    _, wxyz = ellipsoid(inertia, 30.0, np.broadcast_to(np.eye(3), inertia.shape))
    assert np.abs(np.sum(wxyz[1:] * wxyz[:-1], axis=1)).min() > 0.999


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
