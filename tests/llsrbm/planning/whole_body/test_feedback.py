"""Gains along a plan, played in MuJoCo, which knows nothing of them."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import llsrbm
from benchmarks.played import WAYS, play
from llsrbm.body.efforts import efforts
from llsrbm.motion.whole_body import motion_at, pinocchio_states
from llsrbm.planning.whole_body import feedback
from llsrbm.robots import load_robot


@cache
def plan():
    jump = llsrbm.Jump(robot="go2", forward=0.2, twist=0.3)
    return llsrbm.with_feedback(llsrbm.plan(jump))


def test_a_plan_with_gains_is_followed_after_a_push_and_one_without_falls():
    push = np.array([0.0, 1.0, 0.0])
    ends = {way: play(plan(), way, seed=2, push=push) for way in WAYS}
    far, turned = ends["feedback"]
    assert far < 0.02
    assert turned < np.radians(3)
    assert far < ends["joint gains"][0] / 2
    assert ends["torques"][0] > 0.1


def test_gains_are_of_every_knot_and_each_joint_is_turned_back():
    gain, joints = plan().feedback_gain, len(plan().joint_names)
    assert gain.shape == (len(plan().time), joints, 12 + 2 * joints)
    assert np.isfinite(gain).all()
    own = np.diagonal(gain[:, :, 6 : 6 + joints], axis1=1, axis2=2)
    assert (own > 0).all()


def test_gains_in_another_order_turn_the_same_errors_into_the_same_torques():
    rng, names, wanted = np.random.default_rng(0), ("a", "b", "c"), ("c", "a", "b")
    gain, error = rng.normal(size=(2, 3, 18)), rng.normal(size=(2, 9))
    turned = error.copy()
    turned[:, 6:] = error[:, [8, 6, 7]]
    torque = gain @ error.ravel()
    other = feedback.in_order(gain, names, wanted)
    np.testing.assert_allclose(other @ turned.ravel(), torque[:, [2, 0, 1]])
    np.testing.assert_array_equal(feedback.in_order(other, wanted, names), gain)


def test_they_come_with_the_file(tmp_path):
    plan().save(tmp_path / "plan.npz")
    read = llsrbm.load(tmp_path / "plan.npz")
    np.testing.assert_array_equal(read.feedback_gain, plan().feedback_gain)
    assert llsrbm.with_feedback(read) is read
    replace(read, feedback_gain=None).save(tmp_path / "without.npz")
    assert llsrbm.load(tmp_path / "without.npz").feedback_gain is None


@pytest.mark.parametrize("standing", [True, False])
def test_the_dynamics_that_are_made_linear_are_pinocchios(standing):
    """Inverse dynamics of the acceleration gives the torque back."""
    robot = load_robot("go2")
    at = motion_at(plan(), np.array([0.5 * plan().lift_off]))
    q, v = pinocchio_states(at.qpos, at.qvel)
    about = feedback._About(robot, q, v, at.joint_torque)
    about._places = about._stand_at(q[0])
    stands = np.full(len(robot.legs), standing)
    # The torque less what friction takes of it.
    a, _ = about._acceleration(q[0], v[0], about._torque[0], stands)
    if standing:
        force = at.foot_force.reshape(1, -1, 3)
        effort = efforts(robot, q, v, a[None], force)[0]
        # The plan's forces are not quite those that hold the feet: they drift by rows' tolerance.
        np.testing.assert_allclose(effort[6:], at.joint_torque[0], atol=2.0)
    else:
        effort = efforts(robot, q, v, a[None], np.zeros((1, len(robot.legs), 3)))[0]
        np.testing.assert_allclose(effort[:6], 0.0, atol=1e-8)
        np.testing.assert_allclose(effort[6:], at.joint_torque[0], atol=1e-8)
