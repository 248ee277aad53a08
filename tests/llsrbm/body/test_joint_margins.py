"""A real plan between its knots: where the feet are, and joint speeds against differences."""

from __future__ import annotations

import numpy as np
import pytest

import llsrbm
from llsrbm.body.joint_margins import joint_margins
from llsrbm.body.postures import solve_postures
from llsrbm.motion.sampling import resample, with_events
from llsrbm.robots import load_robot
from tests.llsrbm.kinematics import foot_positions


@pytest.fixture(
    scope="module",
    params=[{"twist": 1.57}, {"forward": 0.3}, {"robot": "slider", "twist": 1.57}],
    ids=str,
)
def plan(request):
    return llsrbm.plan(llsrbm.Jump(**request.param))


@pytest.fixture
def robot(plan):
    return load_robot(plan.jump.robot)


def test_feet_of_the_resampled_posture(plan, robot):
    """Pinocchio's forward kinematics of what the page draws and exports hold."""
    motion = resample(plan, with_events(plan, 60.0))
    feet = foot_positions(robot, motion.base_position, motion.base_quat, motion.joint_position)
    assert np.linalg.norm(feet - motion.foot_position, axis=-1).max() < 8e-3


def test_peak_speeds_are_those_of_inverse_kinematics(plan, robot):
    """Differences of postures solved 20 us apart at every end and middle of an interval."""
    dt = np.diff(plan.time)[:, None]
    times = (plan.time[:-1, None] + np.array([0.01, 0.5, 0.99]) * dt).ravel()
    half = 1e-5
    before, after = (
        solve_postures(robot, m.com, m.base_quat, m.foot_position, m.foot_quat).joint_position
        for m in (resample(plan, times - half), resample(plan, times + half))
    )
    peaks = np.abs(after - before).max(axis=0) / (2 * half)
    margins = joint_margins(plan, robot)
    assert [m.joint for m in margins.joints] == list(robot.joint_names)
    got = [m.peak_speed for m in margins.joints]
    # 0.2 rad/s: the Jacobians are taken at the interpolated posture, a few mm from the solved one.
    np.testing.assert_allclose(got, peaks, rtol=0.03, atol=0.2)


def test_peak_speed_is_within_the_limit(plan, robot):
    for margin in joint_margins(plan, robot).joints:
        assert margin.speed_margin > -0.2, margin
