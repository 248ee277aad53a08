"""The one form of a robot's motion, held against Pinocchio and MuJoCo."""

from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation, Slerp

from llsrbm.errors import InputError
from llsrbm.motion.sampling import resample
from llsrbm.motion.whole_body import (
    motion_at,
    motion_at_ticks,
    motion_of_states,
    resultants,
    whole_body_motion,
)
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import (
    ROBOTS,
    by_name,
    mujoco_model,
    planned,
    same_attitude,
    simulated,
    ticks,
)

ROOT = 1  # MuJoCo's number of the root link; 0 is the world


def pinocchio_state(motion, k):
    R = Rotation.from_quat(motion.base_quat[k], scalar_first=True).as_matrix()
    quat = motion.base_quat[k, [1, 2, 3, 0]]
    q = np.concatenate([motion.base_position[k], quat, motion.joint_position[k]])
    v = [R.T @ motion.base_velocity[k], R.T @ motion.angular_velocity[k], motion.joint_velocity[k]]
    return q, np.concatenate(v)


@pytest.mark.parametrize("name", ROBOTS)
def test_the_base_moves_such_that_the_com_moves_as_planned(name):
    plan = planned(name)
    motion = whole_body_motion(plan, fps=50)
    sampled = resample(plan, motion.time)
    model = motion.robot.model
    data = model.createData()
    for k in range(len(motion.time)):
        q, v = pinocchio_state(motion, k)
        pin.centerOfMass(model, data, q, v)
        np.testing.assert_allclose(data.vcom[0], sampled.com_velocity[k], atol=1e-9)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_rollouts_states_are_those_of_the_simulator(name):
    rollout = simulated(name)
    motion = whole_body_motion(rollout, fps=50)
    at = ticks(rollout, 50)
    joints = motion.robot.joint_names
    qpos, qvel = rollout.qpos[at], rollout.qvel[at]
    here = slice(0, len(at))
    np.testing.assert_allclose(motion.qpos[here, :3], qpos[:, :3], atol=1e-9)
    same_attitude(motion.qpos[here, 3:7], qpos[:, 3:7], atol=1e-12)
    np.testing.assert_allclose(
        motion.qpos[here, 7:], by_name(rollout.joint_names, joints, qpos[:, 7:]), atol=1e-9
    )
    np.testing.assert_allclose(motion.qvel[here, :6], qvel[:, :6], atol=1e-9)
    np.testing.assert_allclose(
        motion.qvel[here, 6:], by_name(rollout.joint_names, joints, qvel[:, 6:]), atol=1e-9
    )
    np.testing.assert_array_equal(motion.contact[here], rollout.contact[at].astype(bool))


@pytest.mark.parametrize("name", ROBOTS)
def test_momenta_inertia_and_feet_of_states_are_mujocos(name):
    """Recorded in the simulator, by its own formulas."""
    rollout = simulated(name)
    at = ticks(rollout, 50)
    robot = load_robot(name)
    motion = whole_body_motion(rollout, fps=50)
    of = motion_of_states(robot, "x", motion.time, motion.qpos, motion.qvel, 50)
    model = mujoco_model(name)
    data = mujoco.MjData(model)
    q_at = [model.joint(joint).qposadr[0] for joint in robot.joint_names]
    v_at = [model.joint(joint).dofadr[0] for joint in robot.joint_names]
    for k in range(0, len(at), 4):
        data.qpos[:7], data.qvel[:6] = of.qpos[k, :7], of.qvel[k, :6]
        data.qpos[q_at], data.qvel[v_at] = of.qpos[k, 7:], of.qvel[k, 6:]
        mujoco.mj_forward(model, data)
        mujoco.mj_subtreeVel(model, data)
        np.testing.assert_allclose(of.com[k], data.subtree_com[ROOT], atol=1e-8)
        momentum = robot.mass * data.subtree_linvel[ROOT]
        np.testing.assert_allclose(of.linear_momentum[k], momentum, atol=1e-6)
        np.testing.assert_allclose(of.angular_momentum[k], data.subtree_angmom[ROOT], atol=1e-6)
        for leg, foot in zip(robot.legs, of.foot_position[k], strict=True):
            balls = [i for i in range(model.ngeom) if f"foot/{leg.name}/" in model.geom(i).name]
            lowest = data.geom_xpos[balls].mean(axis=0) - [0, 0, model.geom_size[balls[0], 0]]
            np.testing.assert_allclose(foot, lowest, atol=1e-9)
    np.testing.assert_allclose(of.inertia[: len(at)], rollout.inertia[at], atol=1e-5)


@pytest.mark.parametrize("made", [planned, simulated])
def test_padding_stands_still(made):
    trajectory = made("anymal")
    bare, padded = (whole_body_motion(trajectory, 50, pad) for pad in (0.0, 0.25))
    frames = 13  # 0.25 s at 50 frames/s, rounded up
    assert len(padded.time) == len(bare.time) + 2 * frames
    np.testing.assert_allclose(padded.qpos[frames:-frames], bare.qpos, atol=1e-12)
    np.testing.assert_array_equal(padded.qpos[:frames], bare.qpos[:1].repeat(frames, axis=0))
    np.testing.assert_allclose(padded.qpos[-frames:], bare.qpos[-1:].repeat(frames, 0), atol=1e-12)
    np.testing.assert_allclose(padded.qvel[:frames], 0, atol=1e-12)
    np.testing.assert_allclose(padded.qvel[-frames:], 0, atol=1e-12)
    assert padded.time[0] == 0


def test_attitudes_between_knots_are_near_an_even_turn_and_have_no_steps_of_its_rate():
    plan = planned("anymal")
    knots = Rotation.from_quat(plan.base_quat, scalar_first=True)
    times = np.linspace(0, plan.duration, 500)
    here = Rotation.from_quat(motion_at(plan, times).base_quat, scalar_first=True)
    assert (here.inv() * Slerp(plan.time, knots)(times)).magnitude().max() < 0.02
    even = (knots[:-1].inv() * knots[1:]).as_rotvec() / np.diff(plan.time)[:, None]
    inner = plan.time[1:-1]
    sides = [motion_at(plan, inner + step).angular_velocity for step in (-1e-7, 1e-7)]
    assert np.abs(sides[1] - sides[0]).max() < 1e-3 < np.abs(np.diff(even, axis=0)).max()


def test_another_robots_joints():
    plan = planned("anymal")
    other = replace(plan, joint_names=tuple(f"{name}_" for name in plan.joint_names))
    with pytest.raises(InputError, match="expected the robot that the motion was made with"):
        whole_body_motion(other, 50)


def test_resultants_act_at_the_centre_of_pressure():
    points = np.array([[[0.0, 0, 0], [0.2, 0, 0]]])
    force, at = resultants(points, np.array([[[0.0, 0, 30], [0, 0, 10]]]), feet=1)
    np.testing.assert_allclose(force, [[[0, 0, 40]]])
    np.testing.assert_allclose(at, [[[0.05, 0, 0]]])
    _, unloaded = resultants(points, np.zeros((1, 2, 3)), feet=1)
    np.testing.assert_allclose(unloaded, [[[0.1, 0, 0]]])


def test_a_rollouts_own_ticks_are_taken_as_they_are():
    rollout = simulated("anymal")
    at = np.array([0, 3, 200, len(rollout.time) - 1])
    motion = motion_at_ticks(rollout, at)
    assert motion.fps is None
    assert motion.time.tolist() == rollout.time[at].tolist()
    assert motion.com.tolist() == rollout.com[at].tolist()
    assert motion.foot_force.tolist() == rollout.contact_force[at].tolist()
    joints = by_name(rollout.joint_names, motion.robot.joint_names, rollout.qpos[at, 7:])
    assert motion.joint_position.tolist() == joints.tolist()
    same_attitude(motion.base_quat, rollout.base_quat[at], atol=1e-12)
    np.testing.assert_allclose(motion.qvel[:, :6], rollout.qvel[at, :6], atol=1e-9)


def test_as_text_it_is_a_line():
    motion = whole_body_motion(planned("go2"), 50.0)
    assert repr(motion).startswith("<WholeBodyMotion of go2, plan; ")
    assert len(repr(motion)) < 100
    assert repr(motion.robot).startswith("<Robot go2: ")
