"""The legs' kinematics against differences, and their masses against sums over links."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from llsrbm.mechanics import skew, turns_about_z
from llsrbm.robots import load_robot
from llsrbm.robots.legs import solve_legs

STEP = 1e-6


def links_of(model, joints, q):
    """(n,) masses, (n, 3) CoMs and (n, 3, 3) inertias about them of a leg's links, world frame."""
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    bodies = [data.oMi[j].act(model.inertias[j]) for j in joints]
    return (
        np.array([body.mass for body in bodies]),
        np.array([body.lever for body in bodies]),
        np.array([body.inertia for body in bodies]),
        np.array([data.oMi[j].rotation for j in joints]),
    )


def check(chains, angles):
    """One posture (L, n)."""
    model, motion = chains.model, chains.motion(angles, rotations=True)
    masses = chains.masses(angles)
    joints = chains.joint_ids.tolist()

    def full(q):
        posture = pin.neutral(model)
        for leg, of_leg in zip(joints, q, strict=True):
            posture[[model.joints[j].idx_q for j in leg]] = of_leg
        return posture

    total = pin.computeTotalMass(model)
    for i, leg in enumerate(joints):
        mass, com, inertia, _ = links_of(model, leg, full(angles))
        centre = mass @ com / mass.sum()
        np.testing.assert_allclose(masses.com[i], centre, atol=1e-12)
        arm = skew(com - centre)
        about = inertia + mass[:, None, None] * (arm @ arm.swapaxes(-1, -2))
        np.testing.assert_allclose(masses.inertia[i], about.sum(axis=0), atol=1e-12)
        for j in range(len(leg)):
            turned = np.tile(angles, (2, 1, 1))
            turned[:, i, j] += [STEP, -STEP]
            after, before = (chains.motion(each, rotations=True) for each in turned)
            slope = (after.foot[i] - before.foot[i]) / (2 * STEP)
            np.testing.assert_allclose(motion.foot_jacobian[i, :, j], slope, atol=1e-8)
            turn = pin.log3(after.foot_rotation[i] @ before.foot_rotation[i].T) / (2 * STEP)
            np.testing.assert_allclose(motion.foot_turning[i, :, j], turn, atol=1e-7)
            slope = (after.com - before.com) / (2 * STEP)
            np.testing.assert_allclose(motion.com_jacobian[i, :, j], slope, atol=1e-8)
            links = [links_of(model, leg, full(each)) for each in turned]
            velocity = (links[0][1] - links[1][1]) / (2 * STEP)
            of_leg = mass @ velocity / mass.sum()
            np.testing.assert_allclose(masses.com_jacobian[i, :, j], of_leg, atol=1e-8)
            omega = [pin.log3(a @ b.T) / (2 * STEP) for a, b in zip(*(x[3] for x in links))]
            spin = np.cross(com - centre, mass[:, None] * velocity).sum(axis=0)
            spin += np.einsum("kij,kj->i", inertia, np.array(omega))
            np.testing.assert_allclose(masses.spin[i, :, j], spin, atol=1e-7)
    np.testing.assert_allclose(
        motion.com, pin.centerOfMass(model, model.createData(), full(angles))
    )
    assert total == pytest.approx(chains.mass.sum() + model.inertias[1].mass)


@pytest.mark.parametrize("name", ["anymal", "slider"])
def test_jacobians_and_masses(name):
    robot = load_robot(name)
    rng = np.random.default_rng(0)
    postures = rng.uniform(-1.2, 1.2, size=(2, *robot.leg_joint_index.shape))
    for angles in postures:
        check(robot.chains, angles)
    together = robot.chains.motion(postures)
    np.testing.assert_array_equal(together.foot[1], robot.chains.motion(postures[1]).foot)


@settings(deadline=None, max_examples=30)
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


@settings(deadline=None, max_examples=30)
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
    q, error = solve_legs(robot.chains, target, standing, turns_about_z(yaw))
    assert error.max() < 1e-8
    found = robot.chains.motion(q, rotations=True)
    np.testing.assert_allclose(found.foot, target, atol=1e-8)
    for rotation, angle in zip(found.foot_rotation, yaw, strict=True):
        np.testing.assert_allclose(rotation, pin.rpy.rpyToMatrix(0, 0, angle), atol=1e-7)
