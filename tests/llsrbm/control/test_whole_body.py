from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.control.whole_body import WholeBody
from llsrbm.robots import load_robot
from tests.llsrbm.control.bodies import moved, state

STILL = np.zeros(18)


@pytest.mark.parametrize("seed", range(4))
def test_equation_of_motion_is_pinocchios(seed):
    robot = load_robot("anymal")
    q, v = state(seed)
    body = moved(seed, STILL, 0.0)
    rng = np.random.default_rng(seed)
    force, torque = rng.normal(size=(4, 3)), rng.normal(size=12)
    rhs = np.concatenate([np.zeros(6), torque]) - body.h
    rhs += np.einsum("lin,li->n", body.contact_jacobian, force)
    data = robot.model.createData()
    external = [pin.Force.Zero() for _ in robot.model.joints]
    pin.forwardKinematics(robot.model, data, q)
    for i, leg in enumerate(robot.legs):
        joint = leg.joint_ids[-1]
        point = body.foot[i]
        world = pin.Force(force[i], np.cross(point, force[i]))
        external[joint] = data.oMi[joint].actInv(world)
    expected = pin.aba(robot.model, data, q, v, np.concatenate([np.zeros(6), torque]), external)
    np.testing.assert_allclose(np.linalg.solve(body.M, rhs), expected, rtol=1e-7, atol=1e-6)


def test_centroidal_quantities_follow_from_the_momentum_matrix():
    robot = load_robot("anymal")
    body = moved(3, STILL, 0.0)
    _, v = state(3)
    momentum = body.momentum_matrix @ v
    np.testing.assert_allclose(momentum[:3], robot.mass * body.com_velocity, atol=1e-9)
    np.testing.assert_allclose(momentum[3:], body.angular_momentum, atol=1e-9)


def test_feet_move_as_their_jacobians_say():
    dt = 1e-5
    _, v = state(4)
    before, now, after = (moved(4, STILL, t) for t in (-dt, 0.0, dt))
    np.testing.assert_allclose((after.foot - before.foot) / (2 * dt), now.foot_velocity, atol=1e-6)
    np.testing.assert_allclose(now.foot_jacobian @ v, now.foot_velocity, atol=1e-12)
    np.testing.assert_allclose(now.contact_jacobian @ v, now.contact_velocity, atol=1e-12)
    np.testing.assert_allclose(
        (after.foot_velocity - before.foot_velocity) / (2 * dt), now.foot_bias, atol=1e-4
    )


def test_numbers_of_a_tick_survive_the_next():
    """Whoever keeps the mass matrix over a tick has to copy it; h is a fresh array."""
    body = moved(1, STILL, 0.0)
    h = body.h
    kept = h.copy()
    body.update(*state(2))
    np.testing.assert_array_equal(h, kept)


def test_believes_in_the_robots_own_mass():
    robot = load_robot("anymal")
    assert WholeBody(robot).mass == pytest.approx(robot.mass)
