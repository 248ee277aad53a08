"""Refined plans against Pinocchio, on Go2; those of other robots and schedules are measured."""

from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin
import pytest

import llsrbm
from llsrbm.body.efforts import efforts
from llsrbm.certificate import certified, certify
from llsrbm.motion.sampling import resample
from llsrbm.ocp.horizon import Solution
from llsrbm.planning.answer.planner import planner_of
from llsrbm.planning.whole_body import refine, rounds
from llsrbm.planning.whole_body.apart import Apart
from llsrbm.planning.whole_body.sizes import line
from llsrbm.robots import load_robot
from llsrbm.robots.feet import foot_contacts


@cache
def plans_and_motion():
    first = llsrbm.plan(llsrbm.Jump(robot="go2", forward=0.3, twist=0.4), draft=True)
    refiner = refine.refiner_of(first)
    return (first, refiner.refine(first), load_robot("go2")), refiner.last


def plans():
    """A centroidal plan and the refined one, and the robot."""
    return plans_and_motion()[0]


def motion():
    return plans_and_motion()[1]


@pytest.mark.nightly
def test_it_converges_in_times_that_the_request_allows():
    first, second, robot = plans()
    assert second.refined
    assert not first.refined
    assert second.refinement.iterations < 40
    for name, duration in zip(second.schedule.names, np.diff(second.phase_start), strict=True):
        shortest, longest = getattr(robot.file.timing, {"take-off": "takeoff"}.get(name, name))
        assert shortest - 1e-6 < duration < longest + 1e-6
    assert (second.phase_start[1:] != first.phase_start[1:]).any()
    assert max(v.amount for v in second.violations.values()) < 1e-3
    ends = [0, -1]
    np.testing.assert_allclose(second.com[ends], first.com[ends], atol=2e-3)
    np.testing.assert_allclose(second.foot_position[ends], first.foot_position[ends], atol=2e-3)


def test_feet_come_down_steeply():
    """From 3 cm a fifth of the flight before they land, and not into the ground before."""
    _, second, _ = plans()
    lift, touch = second.lift_off, second.touchdown
    for share, height in ((0.5, 0.03), (0.8, 0.029), (0.9, 0.014), (0.95, 0.0)):
        at = resample(second, np.array([lift + share * (touch - lift)]))
        assert at.foot_position[0, :, 2].min() > height - 0.004


def test_effort_does_not_depend_on_what_was_refined_before():
    """A plan close to a box needs rows that others do not."""
    first, second, _ = plans()
    onto = llsrbm.plan(llsrbm.Jump(robot="go2", height=0.2, forward=0.25), draft=True)
    refine.refined(onto)
    again = refine.refined(first)
    assert again.refinement.iterations == second.refinement.iterations


def test_joints_stay_within_stops_and_drives():
    _, second, robot = plans()
    low, high = robot.kept_stops
    assert (second.joint_position > low - 1e-3).all()
    assert (second.joint_position < high + 1e-3).all()
    assert (np.abs(second.joint_velocity) < robot.speed_limit * 0.91).all()
    assert (np.abs(second.joint_torque) < robot.torque_limit * 0.86).all()


def test_the_base_needs_no_drive_in_the_middles_of_intervals():
    _, second, robot = plans()
    at = motion().at((second.time[1:] + second.time[:-1]) / 2)
    np.testing.assert_allclose(at.force, second.contact_force[:-1], atol=1e-6)
    found = efforts(robot, at.q, at.v, at.a, at.force)
    assert np.abs(found[:, :6]).max() < 1e-3 * robot.mass * 9.81
    np.testing.assert_allclose(found[:, 6:], second.joint_torque[:-1], atol=1e-6)


def test_states_at_knots_are_what_accelerations_lead_to():
    """Just before a knot the motion is as just after it, and velocities are its derivatives."""
    _, _, robot = plans()
    knots, step = motion(), 1e-6
    time = knots.time[1:-1]
    before, after = knots.at(time - 2e-9), knots.at(time)
    np.testing.assert_allclose(before.q, after.q, atol=1e-3)
    np.testing.assert_allclose(before.v, after.v, atol=5e-3)
    inside = (knots.time[1:] + knots.time[:-1]) / 2 + 0.001
    early, late = knots.at(inside - step), knots.at(inside + step)
    moved = np.array(
        [pin.difference(robot.model, a, b) for a, b in zip(early.q, late.q, strict=True)]
    ) / (2 * step)
    np.testing.assert_allclose(moved, knots.at(inside).v, atol=0.02)


def test_sampled_torques_are_those_of_inverse_dynamics():
    """At 1 kHz, from the plan alone, of its joints, forces and torques."""
    _, second, robot = plans()
    time = np.arange(0.0, second.duration, 1e-3)
    sampled, at = resample(second, time), motion().at(time)
    np.testing.assert_allclose(sampled.contact_force, at.force, atol=1e-6)
    np.testing.assert_allclose(sampled.joint_position, at.q[:, 7:], atol=2e-5)
    off = efforts(robot, at.q, at.v, at.a, at.force)[:, 6:] - sampled.joint_torque
    off /= robot.torque_limit
    assert np.sqrt(np.mean(off**2)) < 0.01
    assert np.abs(off).max() < 0.08


def test_its_certificate_finds_what_the_rows_promise_at_1_khz():
    """By code that shares nothing with the planner, between knots too."""
    _, second, _ = plans()
    found = certify(second)
    held = ("joint_position", "joint_speed", "joint_torque", "torque_at_speed", "friction")
    for name in (*held, "contact_force", "slip", "self_distance", "dynamics"):
        assert found[name].holds, found[name]
    assert found["slip"].worst < 2e-3


def test_feet_are_where_the_plan_has_them():
    _, second, robot = plans()
    data = robot.model.createData()
    for k, place in enumerate(second.foot_position):
        q = np.concatenate(
            [second.base_position[k], second.base_quat[k, [1, 2, 3, 0]], second.joint_position[k]]
        )
        pin.framesForwardKinematics(robot.model, data, q)
        for leg, expected in zip(robot.legs, place, strict=True):
            found = data.oMf[leg.foot_frame_id].translation - [0, 0, robot.foot_lift]
            np.testing.assert_allclose(found, expected, atol=3e-3)


def test_balls_roll_where_their_shanks_turn():
    """By Pinocchio: what touches the ground does not move, and the feet's frames do."""
    _, second, robot = plans()
    data, rising = robot.model.createData(), second.time < second.lift_off
    at = motion().at(second.time[rising])
    axes = pin.LOCAL_WORLD_ALIGNED
    for q, v in zip(at.q, at.v, strict=True):
        pin.forwardKinematics(robot.model, data, q, v)
        pin.updateFramePlacements(robot.model, data)
        for leg, contact in zip(robot.legs, foot_contacts(robot), strict=True):
            frame = leg.foot_frame_id
            placed, twist = data.oMf[frame], pin.getFrameVelocity(robot.model, data, frame, axes)
            arm = placed.act(contact.centres[0]) - [0, 0, contact.radius] - placed.translation
            assert np.linalg.norm(twist.linear + np.cross(twist.angular, arm)) < 5e-3
    rolled = second.foot_position[rising] - second.foot_position[0]
    assert np.linalg.norm(rolled[..., :2], axis=-1).max() > 0.01


def test_a_simulated_take_off_takes_the_planned_torques():
    """Of a robot that nothing disturbs."""
    _, second, robot = plans()
    rollout = llsrbm.simulate(certified(second))
    rising = rollout.time < second.lift_off - 0.01
    middle, first = (second.time[1:] + second.time[:-1]) / 2, second.phase[:-1] == 0
    joints = [second.joint_names.index(name) for name in rollout.joint_names]
    planned = second.joint_torque[:-1][first][:, joints].T
    wanted = [np.interp(rollout.time[rising], middle[first], each) for each in planned]
    off = (rollout.torque[rising] - np.transpose(wanted)) / robot.torque_limit[joints]
    assert np.sqrt(np.mean(off**2)) < 0.012


def test_its_file_says_so(tmp_path):
    _, second, _ = plans()
    second.save(tmp_path / "plan.npz")
    again = llsrbm.load(tmp_path / "plan.npz")
    assert again.refined
    assert again.refinement == second.refinement
    np.testing.assert_array_equal(again.joint_torque, second.joint_torque)


def test_gains_of_the_motion_before_are_left():
    _, second, robot = plans()
    gains = llsrbm.with_feedback(second)
    assert gains.feedback_gain is not None
    assert refine.refiner_of(second, robot).refine(gains).feedback_gain is None


def test_where_it_does_not_converge_the_first_plan_stays(monkeypatch):
    first, _, _ = plans()
    for name in ("FROM_FAR", "LOOK"):
        monkeypatch.setattr(rounds, name, replace(rounds.FROM_FAR, iterations=2))
    monkeypatch.setattr(rounds, "ROUNDS", 1)
    kept = refine.refined(first, learned=False)
    assert not kept.refined
    assert kept.refinement.status == "not-converged"
    np.testing.assert_array_equal(kept.joint_position, first.joint_position)


def test_where_a_solver_diverges_the_first_plan_stays(monkeypatch):
    """Its last knots are no numbers: rows of earlier ones hold, and no distances are measured."""
    first, _, _ = plans()
    refiner, measured = refine.refiner_of(first), []

    def diverged(problem, guess, options, watch):
        variables = guess.copy()
        variables[-40:] = np.nan
        return Solution(variables, guess, True, 3, 0.0, 0.0, np.nan, "diverged")

    near = Apart.near
    monkeypatch.setattr(refiner.solver, "solve", diverged)

    def measuring(*given, **others):
        measured.append(given)
        return near(*given, **others)

    monkeypatch.setattr(Apart, "near", measuring)
    kept = refiner.refine(first, learned=False)
    assert kept.refinement.status == "not-converged"
    np.testing.assert_array_equal(kept.joint_position, first.joint_position)
    assert len(measured) == 1  # about the plan


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_lines_are_integrated(share):
    """Of the line 2 + 3 s."""
    nodes = np.array([2.75, 4.25])
    expected = [2 + 3 * share, 2 * share + 1.5 * share**2, share**2 + 0.5 * share**3]
    np.testing.assert_allclose(line(share) @ nodes, expected)


@pytest.mark.nightly
def test_links_keep_apart_where_the_nearest_motion_would_have_them_meet():
    """In a twist with some way forward Go2's front feet cross in mid-flight."""
    jump = llsrbm.Jump(robot="go2", twist=-2.0, forward=0.285, lateral=-0.122, height=-0.072)
    first = planner_of(jump).plan(jump, patient=False)
    second = refine.refined(first)
    assert second.refined
    assert certify(second)["self_distance"].worst > 5e-3
    joints = np.abs(second.joint_position[::2] - first.joint_position[[0]]).max()
    assert joints > 0.5  # legs move


def test_intervals_are_shorter_where_legs_start_and_stop_and_their_halves_are_equal():
    _, second, _ = plans()
    halves = np.diff(second.time)
    np.testing.assert_allclose(halves[::2], halves[1::2], atol=1e-12)
    for phase in range(3):
        steps = halves[second.phase[:-1] == phase]
        if phase > 0:
            assert steps[0] < 0.8 * steps[len(steps) // 2]
        if phase < 2:
            assert steps[-1] < 0.8 * steps[len(steps) // 2]
