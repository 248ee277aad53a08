"""Newton-Euler as expressions against Pinocchio's own, on every robot."""

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest

from llsrbm.models.rigid_bodies import RigidBodies
from llsrbm.robots import load_robot
from tests.llsrbm.kinematics import links_alone, of_drives


@pytest.fixture(params=["anymal", "slider", "g1"])
def robot(request):
    return load_robot(request.param)


def state(robot, seed):
    """Pinocchio's q, v and a of a base at the origin that is level."""
    rng, model = np.random.default_rng(seed), robot.model
    q = np.concatenate([np.zeros(6), [1.0], rng.uniform(-1, 1, model.nq - 7)])
    return q, rng.normal(size=model.nv) * 3, rng.normal(size=model.nv) * 10


def of_pinocchio(robot, q, v, a):
    """Of links, by Pinocchio, and of drives."""
    model, data = links_alone(robot), robot.model.createData()
    effort = pin.rnea(model, data, q, v, a)
    effort[6:] += of_drives(robot, v[6:], a[6:])
    return effort


def function(robot):
    count = len(robot.joint_names)
    q, v, a = (ca.SX.sym(name, count) for name in "qva")
    omega, omega_rate, base = (ca.SX.sym(name, 3) for name in "wxb")
    effort = RigidBodies(robot).inverse_dynamics(q, v, a, omega, omega_rate, base)
    found = ca.vertcat(effort.force, effort.moment, effort.torque)
    return ca.Function("motion", [q, v, a, omega, omega_rate, base], [found])


def test_efforts_are_those_of_pinocchio(robot):
    expressions = function(robot)
    for seed in range(2):
        q, v, a = state(robot, seed)
        # Pinocchio's is a spatial acceleration, in which the base's turning velocity is missing.
        base = a[:3] + np.cross(v[3:6], v[:3]) + [0.0, 0.0, 9.81]
        found = expressions(q[7:], v[6:], a[6:], v[3:6], a[3:6], base)
        expected = of_pinocchio(robot, q, v, a)
        np.testing.assert_allclose(np.array(found).ravel(), expected, atol=1e-8)


def test_pinocchios_own_rotors_are_those(robot):
    q, v, a = state(robot, 3)
    with_rotors, links = (
        pin.rnea(model, model.createData(), q, v, a) for model in (robot.model, links_alone(robot))
    )
    np.testing.assert_allclose(
        with_rotors - links, [*np.zeros(6), *robot.armature * a[6:]], atol=1e-9
    )
