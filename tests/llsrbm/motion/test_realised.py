"""The whole body between a plan's knots: by Pinocchio, on robots with balls and with soles."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.errors import InputError
from llsrbm.motion.realised import realised
from llsrbm.motion.sampling import resample
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import planned as made
from tests.llsrbm.planning.solved import solved

NAMES = ("go2", "slider")
STEP = 1e-6  # s


@pytest.fixture(scope="module", params=NAMES)
def planned(request):
    """Plan, robot, and instants that are no knots."""
    on_soles = request.param == "slider"
    plan = solved("llsrbm-plus", "twist", "slider").plan if on_soles else made("go2")
    times = np.sort(np.random.default_rng(3).uniform(0, plan.duration, 80))
    return plan, load_robot(request.param), times


def at_instants(robot, plan):
    """q and data of forward kinematics at each instant."""
    data = robot.model.createData()
    rows = np.hstack([plan.base_position, plan.base_quat[:, [1, 2, 3, 0]], plan.joint_position])
    for q in rows:
        pin.centerOfMass(robot.model, data, q)
        pin.updateFramePlacements(robot.model, data)
        yield q, data


def test_com_and_feet_are_where_the_plan_has_them(planned):
    plan, robot, times = planned
    motion, plain = realised(plan, robot, times), resample(plan, times)
    lift = np.array([0.0, 0.0, robot.foot_lift])
    stands = plain.contact
    for k, (_, data) in enumerate(at_instants(robot, motion)):
        np.testing.assert_allclose(data.com[0], plain.com[k], atol=1e-6)
        feet = np.array([data.oMf[leg.foot_frame_id].translation for leg in robot.legs]) - lift
        np.testing.assert_allclose(feet, motion.foot_position[k], atol=1e-5)
        # Where a foot stands it is at rest; in the air the planner's lines are near.
        np.testing.assert_allclose(feet[stands[k]], plain.foot_position[k][stands[k]], atol=1e-5)
        np.testing.assert_allclose(feet, plain.foot_position[k], atol=0.03)


def test_the_whole_body_has_the_planned_momentum(planned):
    """But for the smooth rate that takes the base to the next knot."""
    plan, robot, times = planned
    motion = realised(plan, robot, times)
    before, after = (realised(plan, robot, times + step) for step in (-STEP, STEP))
    states = [[q for q, _ in at_instants(robot, each)] for each in (before, after)]
    data = robot.model.createData()
    missing = []
    for k, q in enumerate(q for q, _ in at_instants(robot, motion)):
        v = pin.difference(robot.model, states[0][k], states[1][k]) / (2 * STEP)
        # Velocities are the derivatives of places.
        np.testing.assert_allclose(v[6:], motion.joint_velocity[k], atol=1e-3)
        np.testing.assert_allclose(
            v[3:6],
            pin.Quaternion(q[3:7]).toRotationMatrix().T @ motion.angular_velocity[k],
            atol=1e-3,
        )
        momentum = pin.computeCentroidalMomentum(robot.model, data, q, v)
        np.testing.assert_allclose(
            momentum.linear, robot.mass * motion.com_velocity[k], atol=1e-3 * robot.mass
        )
        missing.append(np.abs(momentum.angular - motion.angular_momentum[k]).max())
    assert max(missing) < 0.05 * np.abs(plan.angular_momentum).max()


def test_knots_are_met(planned):
    plan, robot, _ = planned
    motion = realised(plan, robot, plan.time)
    names = ("base_quat", "base_position", "foot_position", "foot_quat", "joint_position", "com")
    for name in names:
        np.testing.assert_allclose(
            getattr(motion, name), getattr(plan, name), atol=1e-6, err_msg=name
        )


def test_still_before_the_start_and_after_the_end(planned):
    plan, robot, _ = planned
    motion = realised(plan, robot, [-1.0, plan.duration + 1.0])
    assert not motion.joint_velocity.any()
    assert not motion.angular_velocity.any()
    np.testing.assert_allclose(motion.joint_position, plan.joint_position[[0, -1]], atol=1e-6)


def test_of_what_has_no_such_body_it_is_what_resampling_gives(planned):
    plan, robot, times = planned
    report = replace(plan.report, status="not-converged")
    longer = replace(plan, joint_position=plan.joint_position + 0.1)
    for other in (replace(plan, report=report), longer, replace(plan, joint_velocity=None)):
        motion, plain = realised(other, robot, times), resample(other, times)
        np.testing.assert_array_equal(motion.joint_position, plain.joint_position)
    with pytest.raises(InputError, match="finite"):
        realised(plan, robot, [np.nan])
