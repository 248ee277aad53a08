"""Plans with free arms: G1 with its arms shaping its inertia, checked by Pinocchio."""

from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin
import pytest

import llsrbm
from llsrbm.body.momentum import momentum_and_inertia
from llsrbm.mechanics import interpolated
from llsrbm.models import make_model
from llsrbm.motion.realised import realised
from llsrbm.planning.problem.knots import unpack
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.replan.replanner import Replanner
from llsrbm.planning.replan.under_way import planned_state
from llsrbm.planning.solve.guess import analytic_guess
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.robots import load_robot

ROBOT = load_robot("g1")
ARMS = ROBOT.arm_joint_index
TWIST = llsrbm.Jump(robot="g1", twist=2.0)
solves = pytest.mark.nightly  # with the largest solvers that there are


@cache
def plan():
    return llsrbm.plan(TWIST, draft=True)


@solves
def test_arms_begin_and_end_as_they_hang_and_stay_within_their_ends():
    angles, speeds = plan().joint_position[:, ARMS], plan().joint_velocity[:, ARMS]
    np.testing.assert_allclose(angles[[0, -1]], np.tile(ROBOT.arm_angles, (2, 1)), atol=1e-4)
    np.testing.assert_allclose(speeds[[0, -1]], 0.0, atol=1e-3)
    low, high = ROBOT.arm_ends
    assert (angles > low - 1e-3).all()
    assert (angles < high + 1e-3).all()
    assert np.ptp(angles, axis=0).max() > 0.5


def test_held_arms_stay():
    """By the postures of a plan's variables, here those of its guess."""
    held = replace(TWIST, arms="held")
    task, layout = make_task(held, ROBOT), layout_of(held, ROBOT)
    model = make_model(held.model, ROBOT)
    knots = unpack(analytic_guess(task, layout, model), layout, task, model)
    assert np.abs(knots.postures.joint_position[:, ARMS] - ROBOT.arm_angles).max() < 1e-9


@solves
def test_arms_that_move_change_the_inertia_more():
    """Against the same motion of the legs with arms that hang, by Pinocchio."""
    hanging, still = plan().joint_position.copy(), np.zeros_like(plan().joint_position)
    hanging[:, ARMS] = ROBOT.arm_angles
    rate = np.zeros((len(still), 3))
    inertia = [
        momentum_and_inertia(ROBOT, joints, still, rate)[1]
        for joints in (plan().joint_position, hanging)
    ]
    spread = [np.ptp(each[:, 2, 2]) for each in inertia]
    assert spread[0] > 1.3 * spread[1]


@solves
def test_the_whole_body_has_the_planned_momentum_in_flight():
    """Pinocchio on the realised motion: the momentum that the plan says, within 5 % of its peak."""
    times = np.linspace(plan().lift_off, plan().touchdown, 30)[1:-1]
    motion = realised(plan(), ROBOT, times)
    back = [pin.Quaternion(np.roll(q, -1)).matrix().T for q in motion.base_quat]
    rate = np.array([M @ w for M, w in zip(back, motion.angular_velocity)])
    momentum, inertia = momentum_and_inertia(
        ROBOT, motion.joint_position, motion.joint_velocity, rate
    )
    planned = np.array([M @ L for M, L in zip(back, motion.angular_momentum)])
    peak = np.abs(plan().angular_momentum[:, 2]).max()
    assert np.sqrt(np.mean((momentum - planned)[:, 2] ** 2)) < 0.05 * peak
    modelled = np.array([M @ tensor @ M.T for M, tensor in zip(back, motion.inertia)])
    off = (modelled - inertia)[:, 2, 2] / inertia[:, 2, 2]
    assert np.sqrt(np.mean(off**2)) < 0.03


@solves
def test_feet_and_com_are_where_planned_however_the_arms_are():
    """The postures' CoM moves as planned, by differences."""
    model, data = ROBOT.model, ROBOT.model.createData()
    for k in range(0, len(plan().time), 6):
        q = np.concatenate(
            [plan().base_position[k], np.roll(plan().base_quat[k], -1), plan().joint_position[k]]
        )
        v = np.zeros(model.nv)
        pin.centerOfMass(model, data, q, v)
        np.testing.assert_allclose(data.com[0], plan().com[k], atol=1e-6)
        pin.updateFramePlacements(model, data)
        for leg, place in zip(ROBOT.legs, plan().foot_position[k]):
            np.testing.assert_allclose(data.oMf[leg.foot_frame_id].translation, place, atol=1e-5)


def test_problems_of_free_and_of_held_arms_differ():
    for change, joints in (({}, len(ARMS)), ({"arms": "held"}, 0), ({"model": "srbm"}, 0)):
        assert layout_of(replace(TWIST, **change), ROBOT).arm_joints == joints


@solves
def test_what_remains_is_planned_anew_from_arms_in_motion():
    replanner = Replanner(plan(), ROBOT)
    state = planned_state(plan(), 1)
    time = state.time + 0.05
    joints = interpolated(state.time, plan().time, plan().joint_position)
    speeds = interpolated(state.time, plan().time, plan().joint_velocity)
    answer = replanner.replan(replace(state, joints=joints, joint_speeds=speeds))
    assert answer.plan is not None
    new = interpolated(time, answer.plan.time, answer.plan.joint_position)[ARMS]
    old = interpolated(time, plan().time, plan().joint_position)[ARMS]
    assert np.abs(new - old).max() < 0.5


@pytest.mark.parametrize("wrong", ["bound", "", 3])
def test_other_words_for_arms_are_refused(wrong):
    with pytest.raises(llsrbm.InputError, match="arms"):
        llsrbm.Jump(robot="g1", arms=wrong)
