"""Drives and payloads that a request states, end to end on Go2: planner to simulation."""

from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pytest

import llsrbm
from llsrbm.analysis.drafts import draft_reason
from llsrbm.motion.robot import robot_of
from llsrbm.planning.answer.planner import planner_of
from llsrbm.robots import load_robot

ROBOT = load_robot("go2")
JUMP = llsrbm.Jump(robot="go2", forward=0.35, twist=0.8)
WEAK = {"drive_strength": 0.65, "battery": 0.8}


@cache
def plan():
    return llsrbm.plan(JUMP, limits=WEAK, guesses=False)


@pytest.mark.nightly
def test_a_plan_keeps_to_drives_that_are_weaker_than_the_file_says():
    assert plan().certified
    assert {name: plan().limits[name] for name in WEAK} == WEAK
    order = [ROBOT.joint_names.index(name) for name in plan().joint_names]
    torque = np.abs(plan().joint_torque) / ROBOT.rated_torque[order]
    speed = np.abs(plan().joint_velocity) / ROBOT.rated_speed[order]
    own = ROBOT.file.limits  # rows hold to a thousandth or two
    assert torque.max() <= 0.65 * own.torque_share + 2e-3
    assert speed.max() <= 0.8 * own.speed_share + 2e-3
    # With all of its drives it uses more.
    strong = llsrbm.plan(JUMP, draft=True)
    assert np.abs(strong.joint_velocity / ROBOT.rated_speed[order]).max() > 0.8 * own.speed_share


def test_the_certificate_is_of_the_drives_as_they_are():
    weaker = replace(plan(), limits={**plan().limits, "drive_strength": 0.5, "battery": 0.6})
    one, other = llsrbm.certify(plan()), llsrbm.certify(weaker)
    for name, ratio in (("joint_torque", 0.65 / 0.5), ("joint_speed", 0.8 / 0.6)):
        assert other[name].worst == pytest.approx(ratio * one[name].worst, rel=1e-6)
    assert not other.holds


def test_a_simulation_has_them_and_the_controller_knows():
    rollout = llsrbm.simulate(plan())
    assert rollout.landed
    order = [ROBOT.joint_names.index(name) for name in rollout.joint_names]
    most = rollout.torque_limit.max(axis=0) / ROBOT.rated_torque[order]
    np.testing.assert_allclose(most, 0.65, rtol=1e-6)


def test_no_solver_is_built_for_other_drives():
    """And rotors, friction and everything else stay as they are."""
    robot = robot_of(plan())
    assert robot.rated is load_robot("go2")
    assert planner_of(JUMP, robot=robot) is planner_of(JUMP)
    for name in ("armature", "friction", "damping"):
        np.testing.assert_array_equal(getattr(robot, name), getattr(ROBOT, name))
    assert plan().robot_parameters == ROBOT.parameters()


@pytest.mark.nightly
def test_what_is_limited_is_said_of_the_drives_as_they_are():
    far = llsrbm.Jump(robot="go2", forward=0.6)
    with pytest.raises(llsrbm.NotConverged) as caught:
        llsrbm.plan(far, limits={"drive_strength": 0.35}, draft=True)
    stop = caught.value.stops[0]
    assert stop.limit not in WEAK  # no drive grows stronger for being asked
    rated = ROBOT.rated_torque[ROBOT.joint_names.index(stop.demand.joint)]
    assert 0.25 * rated < stop.demand.has <= 0.35 * rated


# ---- payloads

CARRYING = replace(JUMP, payload=(4.0, 0.05, 0.0, 0.1))


@cache
def carried():
    return llsrbm.plan(CARRYING, guesses=False)


def test_a_plan_with_a_payload_is_certified_and_lands():
    """The ground carries it at the end."""
    assert carried().certified
    assert carried().jump == CARRYING
    assert carried().robot_parameters["mass"] == pytest.approx(ROBOT.mass + 4.0)
    rollout = llsrbm.simulate(carried())
    assert rollout.landed
    weight = (ROBOT.mass + 4.0) * 9.81
    assert rollout.contact_force[-1, :, 2].sum() == pytest.approx(weight, rel=0.02)
    # Without it the same motion misses Newton's equations.
    alone = replace(carried(), jump=JUMP)
    assert not llsrbm.certify(alone).holds


def test_its_file_has_it(tmp_path):
    carried().save(tmp_path / "plan.npz")
    assert llsrbm.load(tmp_path / "plan.npz").jump == CARRYING


def test_an_export_for_mujoco_has_it(tmp_path):
    llsrbm.export(carried(), tmp_path / "out", "mujoco")
    masses = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / "scene.xml")).body_mass
    assert masses.sum() == pytest.approx(ROBOT.mass + 4.0, rel=1e-6)


def test_another_plan_may_begin_from_it():
    near = llsrbm.plan(replace(CARRYING, forward=0.42), near=carried(), draft=True)
    assert near.solved
    assert near.jump.payload == CARRYING.payload


def test_a_draft_is_of_the_robot_alone_and_says_so():
    draft = llsrbm.plan(CARRYING, draft=True)
    assert draft_reason(draft) == "it is of the robot without its payload"
    with pytest.raises(llsrbm.InputError, match="without its payload"):
        llsrbm.simulate(draft)


def test_it_is_not_planned_anew():
    with pytest.raises(llsrbm.InputError, match="expected a plan without a payload"):
        llsrbm.simulate(carried(), replan=True)
