"""The batched kinematics of the legs, against Pinocchio posture by posture."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from llsrbm.mechanics import cross, parallel_axis, rotation_matrices, skew, turns_about_z
from llsrbm.robots import load_robot
from llsrbm.robots.legs import LegChains, solve_legs
from tests.llsrbm.robots.test_robot import QUADRUPEDS

EVERY_ROBOT = [*QUADRUPEDS, "slider"]


def by_pinocchio(model, joints, foot, q):
    """Foot, its rotation, CoM, inertia, Jacobians and spin of one leg, the base at the origin."""
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    pin.ccrba(model, data, q, np.zeros(model.nv))
    v = [model.joints[j].idx_v for j in joints]
    body = data.oMi[joints[0]].act(model.inertias[joints[0]])
    for j in joints[1:]:
        body = body + data.oMi[j].act(model.inertias[j])
    com_jacobian = data.Ag[:3, v] / body.mass
    spin = data.Ag[3:, v] - np.cross(body.lever - data.com[0], body.mass * com_jacobian.T).T
    foot_jacobian = pin.getFrameJacobian(model, data, foot, pin.LOCAL_WORLD_ALIGNED)[:, v]
    place = data.oMf[foot]
    return (
        place.translation,
        place.rotation,
        body.lever,
        body.inertia,
        foot_jacobian[:3],
        foot_jacobian[3:],
        com_jacobian,
        spin,
    )


def by_us(chains, q):
    """The same of all legs."""
    motion = chains.motion(q)
    rotation, turning = chains.foot_turning(motion)
    inertia, spin = chains.inertia_and_spin(motion)
    return (
        motion.foot,
        rotation,
        motion.com,
        inertia,
        motion.foot_jacobian,
        turning,
        motion.com_jacobian,
        spin,
    )


@pytest.mark.parametrize("name", EVERY_ROBOT)
def test_every_quantity_is_pinocchios(name):
    robot = load_robot(name)
    rng = np.random.default_rng(0)
    postures = rng.uniform(-1.5, 1.5, size=(4, *robot.leg_joint_index.shape))
    ours = by_us(robot.chains, postures)
    for k, angles in enumerate(postures):
        q = pin.neutral(robot.model)
        for i, leg in enumerate(robot.legs):
            q[leg.q_index] = angles[i]
        for i, leg in enumerate(robot.legs):
            truth = by_pinocchio(robot.model, leg.joint_ids, leg.foot_frame_id, q)
            for a, b in zip(ours, truth, strict=True):
                np.testing.assert_allclose(a[k, i], b, atol=1e-12)


def test_sliding_joints_too():
    """A leg of two turning joints and a sliding one between them (as SLIDER's)."""
    model = pin.Model()
    root = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root")
    model.appendBodyToJoint(root, pin.Inertia.Random(), pin.SE3.Identity())
    rng = np.random.default_rng(3)
    joints, parent = [], root
    kinds = (
        pin.JointModelRX(),
        pin.JointModelPrismaticUnaligned(0.6, 0.0, -0.8),
        pin.JointModelRY(),
    )
    for i, kind in enumerate(kinds):
        placement = pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(size=3))
        parent = model.addJoint(parent, kind, placement, f"joint{i}")
        model.appendBodyToJoint(parent, pin.Inertia.Random(), pin.SE3.Identity())
        joints.append(parent)
    tip = pin.SE3(pin.exp3(rng.normal(size=3)), np.array([0.1, 0.2, -0.3]))
    foot = model.addFrame(pin.Frame("foot", parent, tip, pin.FrameType.OP_FRAME))
    chains = LegChains.from_model(model, [joints], [foot])
    assert chains.prismatic.tolist() == [False, True, False]
    q = pin.neutral(model)
    q[7:] = 0.3, -0.4, 0.8
    truth = by_pinocchio(model, joints, foot, q)
    for a, b in zip(by_us(chains, q[None, 7:]), truth, strict=True):
        np.testing.assert_allclose(a[0], b, atol=1e-12)


@settings(deadline=None, max_examples=40)
@given(where=arrays(float, (4, 3), elements=st.floats(0, 1)))
def test_feet_anywhere_in_the_reach_box_are_found(where):
    robot = load_robot("anymal")
    reach = robot.file.reach
    low, high = np.array(reach.lower), np.array(reach.upper)
    x = low + where * (high - low)
    length = np.linalg.norm(x, axis=1, keepdims=True)
    x *= np.clip(length, *reach.distance) / length
    target = robot.hips + robot.mirrors * x
    standing = np.array([robot.file.posture[leg.name] for leg in robot.legs])
    q, error = solve_legs(robot.chains, target, standing)
    assert error.max() < 1e-8
    np.testing.assert_allclose(robot.chains.motion(q).foot, target, atol=1e-8)
    # The knee bends to its own side, as it does when standing.
    assert (np.sign(q[:, 2]) == np.sign(standing[:, 2])).all()


@settings(deadline=None, max_examples=40)
@given(where=arrays(float, (2, 4), elements=st.floats(0, 1)))
def test_soles_anywhere_in_the_reach_box_lie_level_at_their_yaw(where):
    robot = load_robot("slider")
    reach, turn = robot.file.reach, robot.file.foot.yaw
    low, high = np.array([*reach.lower, turn[0]]), np.array([*reach.upper, turn[1]])
    *xyz, yaw = (low + where * (high - low)).T
    x = np.transpose(xyz)
    length = np.linalg.norm(x, axis=1, keepdims=True)
    target = robot.hips + robot.mirrors * x * np.clip(length, *reach.distance) / length
    standing = np.array([robot.file.posture[leg.name] for leg in robot.legs])
    soles = turns_about_z(yaw)
    q, error = solve_legs(robot.chains, target, standing, soles)
    assert error.max() < 1e-8
    pin_q = pin.neutral(robot.model)
    for leg, angles in zip(robot.legs, q, strict=True):
        pin_q[leg.q_index] = angles
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, pin_q)
    for i, leg in enumerate(robot.legs):
        place = data.oMf[leg.foot_frame_id]
        np.testing.assert_allclose(place.translation, target[i], atol=1e-8)
        np.testing.assert_allclose(place.rotation, pin.rpy.rpyToMatrix(0, 0, yaw[i]), atol=1e-7)


def test_a_foot_out_of_reach_leaves_an_error_and_no_nonsense():
    robot = load_robot("anymal")
    standing = np.array([robot.file.posture[leg.name] for leg in robot.legs])
    target = robot.hips + np.array([0, 0, -1.0])
    q, error = solve_legs(robot.chains, target, standing)
    assert np.isfinite(q).all()
    assert (error > 0.3).all()
    assert (error < 0.6).all()


vectors = arrays(float, (3,), elements=st.floats(-10, 10))


@given(a=vectors, b=vectors)
def test_vector_algebra(a, b):
    np.testing.assert_allclose(cross(a, b), np.cross(a, b), atol=1e-12)
    np.testing.assert_allclose(skew(a) @ b, np.cross(a, b), atol=1e-12)
    np.testing.assert_allclose(parallel_axis(a), -skew(a) @ skew(a), atol=1e-10)


@given(turn=vectors)
def test_quaternions_are_w_x_y_z(turn):
    quat = pin.Quaternion(pin.exp3(turn)).coeffs()
    np.testing.assert_allclose(rotation_matrices(quat[[3, 0, 1, 2]]), pin.exp3(turn), atol=1e-12)
