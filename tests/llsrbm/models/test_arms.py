"""Free arms against Pinocchio: G1's whole body in random postures of its arms, moving at random."""

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest

from llsrbm.models import free_arms_of, make_model
from llsrbm.models.base import no_lift
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot

ROBOT = load_robot("g1")
FREE = make_model("llsrbm-plus", ROBOT, free_arms=True)
HELD = make_model("llsrbm-plus", ROBOT)
INDEX = ROBOT.arm_joint_index


def standing_feet():
    places = ROBOT.feet - ROBOT.base_position - ROBOT.hips
    return ca.DM(np.vstack([(ROBOT.mirrors * places).T, np.zeros(2)]))


def moving(seed):
    """Angles, rates and accelerations of the arms, and the base's rate."""
    rng = np.random.default_rng(seed)
    angles = rng.uniform(*ROBOT.arm_ends)
    return angles, rng.normal(scale=5, size=8), rng.normal(scale=60, size=8), rng.normal(size=3)


def whole(angles, rates, omega):
    """Pinocchio's data, legs as they stand, the base at the origin."""
    q, v = pin.neutral(ROBOT.model), np.zeros(ROBOT.model.nv)
    q[7:] = ROBOT.posture[7:]
    q[7:][INDEX], v[3:6], v[6:][INDEX] = angles, omega, rates
    data = ROBOT.model.createData()
    pin.ccrba(ROBOT.model, data, q, v)
    return q, v, data


def columns(*values):
    return [np.array(ca.DM(value)) for value in values]


@pytest.mark.parametrize("seed", range(2))
def test_what_arms_add_is_exact(seed):
    """What is left is the legs' maps: the same with arms as they hang, at rest."""
    x, still = standing_feet(), np.zeros(8)

    def errors(angles, rates, omega):
        arms = FREE.arms.carried(ca.SX(ca.DM(angles)), ca.SX(ca.DM(rates)), no_lift)
        o = FREE.base_offset(x, arms)
        motion = x, 0 * x, ca.DM(omega), o, no_lift, arms
        o, inertia, L = columns(o, FREE.inertia(x, o, arms), FREE.angular_momentum(*motion))
        data = whole(angles, rates, omega)[2]
        return o[:, 0] + data.com[0], inertia - data.Ig.inertia, L[:, 0] - data.hg.angular

    angles, rates, _, omega = moving(seed)
    offset, inertia, momentum = errors(angles, rates, omega)
    legs = errors(ROBOT.arm_angles, still, omega)
    np.testing.assert_allclose(offset, legs[0], atol=1e-9)
    assert np.abs(inertia).max() < np.abs(legs[1]).max() + 1e-3
    assert np.linalg.norm(momentum) < np.linalg.norm(legs[2]) + 0.02
    by_rates = whole(angles, rates, 0 * omega)[2].hg.angular
    assert np.linalg.norm(momentum) < 0.05 * np.linalg.norm(by_rates) + np.linalg.norm(legs[2])


@pytest.mark.parametrize("seed", range(2))
def test_torques_are_those_of_inverse_dynamics(seed):
    angles, rates, accelerations, omega = moving(seed)
    force, turning = np.array([1.0, -2.0, 15.0]), np.array([20.0, -30.0, 80.0])
    values = angles, rates, accelerations, omega, turning, force
    given = (ca.SX(ca.DM(each)) for each in values)
    (torque,) = columns(FREE.arms.torques(*given, no_lift))
    q, v, data = whole(angles, rates, omega)
    a = np.zeros(ROBOT.model.nv)
    a[:3] = force + ROBOT.model.gravity.linear
    a[3:6], a[6:][INDEX] = turning, accelerations
    turned = v[6:] / np.hypot(v[6:], 0.03 * ROBOT.speed_limit)
    friction = ROBOT.friction * turned + ROBOT.damping * v[6:]
    expected = (pin.rnea(ROBOT.model, data, q, v, a)[6:] + friction)[INDEX]
    np.testing.assert_allclose(torque[:, 0], expected, atol=1e-9)


@pytest.mark.parametrize("standing", [(), (0,), (0, 1)])
def test_the_base_is_where_the_com_says_however_feet_are_given(standing):
    arms = FREE.arms.carried(*(ca.SX(ca.DM(each)) for each in moving(0)[:2]), no_lift)
    x = standing_feet()
    (o,) = columns(FREE.base_offset(x, arms))
    seen = {i: FREE.foot_from_com(i, x[:, i], ca.DM(o)) for i in standing}
    feet = {i: ca.vertcat(seen[i], 0) if i in seen else x[:, i] for i in range(2)}
    (found,) = columns(FREE.offset_map(standing)(feet, arms))
    np.testing.assert_allclose(found, o, atol=1e-9)


def test_held_arms_are_part_of_the_base():
    x = standing_feet()
    arms = FREE.arms.carried(ca.SX(ca.DM(ROBOT.arm_angles)), ca.SX.zeros(8), no_lift)
    o = HELD.base_offset(x)
    found = columns(o, HELD.inertia(x, o))
    expected = columns(FREE.base_offset(x, arms), FREE.inertia(x, o, arms))
    for one, other in zip(found, expected):
        np.testing.assert_allclose(one, other, atol=1e-9)
    assert HELD.base_mass == pytest.approx(FREE.base_mass + FREE.arms.mass)
    legs = make_model("llsrbm-plus", load_robot("g1_legs"))
    assert HELD.base_mass == pytest.approx(legs.base_mass)


@pytest.mark.parametrize(
    ("request_", "free"),
    [
        (Jump(robot="g1"), True),
        (Jump(robot="g1", arms="held"), False),
        (Jump(robot="g1", model="srbm"), False),
        (Jump(robot="g1_legs"), False),
    ],
)
def test_arms_move_where_there_are_some_and_the_model_can(request_, free):
    assert free_arms_of(request_, load_robot(request_.robot)) is free
