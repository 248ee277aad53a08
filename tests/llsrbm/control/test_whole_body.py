import numpy as np
import pinocchio as pin
import pytest

from llsrbm.control.whole_body import WholeBody
from llsrbm.robots import load_robot
from llsrbm.robots.feet import foot_contacts
from tests.llsrbm.control.bodies import ROBOTS, moved, state

STILL = np.zeros(18)


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("seed", range(1))
def test_equation_of_motion_is_pinocchios(seed, name):
    robot = load_robot(name)
    q, v = state(seed, name)
    body = moved(seed, STILL, 0.0, name)
    rng = np.random.default_rng(seed)
    force = rng.normal(size=(body.contacts, 3))
    torque = rng.normal(size=robot.model.nv - 6)
    rhs = np.concatenate([np.zeros(6), torque]) - body.h
    rhs += np.einsum("cin,ci->n", body.contact_jacobian, force)
    data = robot.model.createData()
    external = [pin.Force.Zero() for _ in robot.model.joints]
    pin.framesForwardKinematics(robot.model, data, q)
    corners = len(robot.corners)
    for i, (leg, contact) in enumerate(zip(robot.legs, foot_contacts(robot), strict=True)):
        joint = leg.joint_ids[-1]
        for j, centre in enumerate(contact.centres):
            point = data.oMf[leg.foot_frame_id].act(centre) - [0, 0, contact.radius]
            f = force[corners * i + j]
            external[joint] += data.oMi[joint].actInv(pin.Force(f, np.cross(point, f)))
    expected = pin.aba(robot.model, data, q, v, np.concatenate([np.zeros(6), torque]), external)
    np.testing.assert_allclose(np.linalg.solve(body.M, rhs), expected, rtol=1e-7, atol=1e-6)


def test_centroidal_quantities_follow_from_the_momentum_matrix():
    robot = load_robot("anymal")
    body = moved(3, STILL, 0.0)
    _, v = state(3)
    momentum = body.momentum_matrix @ v
    np.testing.assert_allclose(momentum[:3], robot.mass * body.com_velocity, atol=1e-9)
    np.testing.assert_allclose(momentum[3:], body.angular_momentum, atol=1e-9)


def test_momenta_alone_are_those_of_the_whole_state():
    whole, alone = WholeBody(load_robot("anymal")), WholeBody(load_robot("anymal"))
    whole.update(*state(3))
    alone.update(*state(4))
    alone.update_momentum(*state(3))
    names = ("com", "com_velocity", "angular_momentum", "inertia", "trunk_momentum")
    for name in names:
        np.testing.assert_allclose(getattr(alone, name), getattr(whole, name), atol=1e-12)


@pytest.mark.parametrize("name", ROBOTS)
def test_feet_move_as_their_jacobians_say(name):
    dt = 1e-5
    _, v = state(4, name)
    before, now, after = (moved(4, STILL, t, name) for t in (-dt, 0.0, dt))
    np.testing.assert_allclose((after.foot - before.foot) / (2 * dt), now.foot_velocity, atol=1e-6)
    np.testing.assert_allclose(now.foot_jacobian @ v, now.foot_velocity, atol=1e-12)
    np.testing.assert_allclose(now.contact_jacobian @ v, now.contact_velocity, atol=1e-12)
    np.testing.assert_allclose(
        (after.foot_velocity - before.foot_velocity) / (2 * dt), now.foot_bias, atol=1e-4
    )
    np.testing.assert_allclose(
        now.foot_rotation_jacobian @ v, now.foot_angular_velocity, atol=1e-12
    )
    np.testing.assert_allclose(
        (after.foot_angular_velocity - before.foot_angular_velocity) / (2 * dt),
        now.foot_rotation_bias,
        atol=1e-4,
    )
    turn = (after.R_world_foot - before.R_world_foot) / (2 * dt)
    spin = np.cross(now.foot_angular_velocity[:, None], now.R_world_foot.transpose(0, 2, 1))
    np.testing.assert_allclose(turn, spin.transpose(0, 2, 1), atol=1e-5)


@pytest.mark.parametrize("name", ["slider", "g1", "talos"])
def test_soles_are_where_plans_place_them(name):
    """Wherever in a sole the URDF's spheres are."""
    robot = load_robot(name)
    body, data = WholeBody(robot), robot.model.createData()
    body.update(robot.posture, np.zeros(robot.model.nv))
    pin.framesForwardKinematics(robot.model, data, robot.posture)
    places = np.array([data.oMf[leg.foot_frame_id].translation for leg in robot.legs])
    np.testing.assert_allclose(body.foot, places, atol=1e-4)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_heavier_trunk_has_more_of_the_trunks_momentum(name):
    """By finite differences of the trunk's mass, about the CoM as it then is."""
    robot, share = load_robot(name), 1e-6
    q, v = state(5, name)
    body = moved(5, STILL, 0.0, name)

    def momenta(factor):
        model = robot.model.copy()
        trunk = model.inertias[1]
        model.inertias[1] = pin.Inertia(trunk.mass * factor, trunk.lever, trunk.inertia * factor)
        data = model.createData()
        pin.ccrba(model, data, q, v)
        pin.centerOfMass(model, data, q, v)
        return np.concatenate([robot.mass * data.vcom[0], data.hg.angular])

    change = (momenta(1 + share) - momenta(1 - share)) / (2 * share)
    np.testing.assert_allclose(body.trunk_momentum, change, rtol=1e-5, atol=1e-5)
