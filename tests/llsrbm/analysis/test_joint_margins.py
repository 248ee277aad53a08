"""A real plan between its knots: where the feet are, and joint speeds against differences."""

import numpy as np
import pytest

from llsrbm.analysis.joint_margins import joint_margins, margins
from llsrbm.body.postures import solve_postures
from llsrbm.certificate import stated
from llsrbm.library import shipped
from llsrbm.motion.sampling import resample
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import planned


@pytest.fixture(params=["go2", "g1_legs"])
def plan(request):
    return planned(request.param)


@pytest.fixture
def robot(plan):
    return load_robot(plan.jump.robot)


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


@pytest.mark.parametrize("kind", ["rear-last", "together", "route"])
def test_the_peak_of_a_whole_bodys_plan_is_that_of_its_certificate(kind):
    """By the checker, which samples the motion at 1 kHz; feet's places jump by millimetres."""
    name = next(card.name for card in shipped().cards if card.kind == kind)
    plan = shipped().open(name)
    finding = stated(plan)["joint_speed"]
    found = joint_margins(plan, load_robot(plan.jump.robot)).joints
    shares = [m.peak_speed / (m.peak_speed + m.speed_margin) for m in found]
    assert max(shares) == pytest.approx(finding.worst, rel=0.03)


def test_margins_name_the_joint_and_the_time():
    robot = load_robot("anymal")
    time = np.array([0.0, 0.1, 0.2])
    position = np.tile(robot.posture[7:], (3, 1))
    speed = np.zeros((3, 12))
    knee = robot.joint_names.index("RF_KFE")
    hip = robot.joint_names.index("LH_HFE")
    speed[1, knee] = -17.0
    position[2, hip] = 9.5
    found = margins(robot, time, position, speed)
    assert found["RF_KFE"].peak_speed == 17.0
    assert found["RF_KFE"].speed_margin == pytest.approx(-2.0)
    assert found["RF_KFE"].speed_time == 0.1
    assert found["LH_HFE"].position_margin == pytest.approx(-0.08)
    assert found["LH_HFE"].position_time == 0.2
    assert found["LF_HAA"].position_margin == pytest.approx(9.42 - 0.1)
    assert found.worst() == (
        "RF_KFE is fastest, 17.0 of 15.0 rad/s at 0.10 s; "
        "LH_HFE comes nearest to a stop, 0.08 rad beyond its limits at 0.20 s."
    )
