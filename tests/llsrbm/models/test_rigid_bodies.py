"""Newton-Euler as expressions against Pinocchio's own, on every robot."""

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest

from llsrbm.models.rigid_bodies import RigidBodies
from llsrbm.robots import load_robot, names

UP = ca.DM([0, 0, 1])


@pytest.fixture(params=names())
def robot(request):
    return load_robot(request.param)


def state(robot, seed):
    """Pinocchio's q, v and a of a base at the origin that is level, and forces (L, c, 3) N."""
    rng, model = np.random.default_rng(seed), robot.model
    q = np.concatenate([np.zeros(6), [1.0], rng.uniform(-1, 1, model.nq - 7)])
    forces = rng.normal(size=(len(robot.legs), len(robot.corners), 3)) * 50
    return q, rng.normal(size=model.nv) * 3, rng.normal(size=model.nv) * 10, forces


def links_alone(robot):
    model = robot.model.copy()
    model.armature[:] = 0.0
    return model


def of_drives(robot, dq, ddq):
    """Nm or N of rotors, damping, and friction that turns about within 3 % of the speed limit."""
    turned = dq / np.hypot(dq, 0.03 * robot.speed_limit)
    return robot.armature * ddq + robot.friction * turned + robot.damping * dq


def of_pinocchio(robot, q, v, a, forces):
    """Of links, by Pinocchio, and of drives."""
    model, data = links_alone(robot), robot.model.createData()
    effort = pin.rnea(model, data, q, v, a)
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    for leg, pushes in zip(robot.legs, forces, strict=True):
        J = pin.getFrameJacobian(model, data, leg.foot_frame_id, pin.LOCAL_WORLD_ALIGNED)
        arms = robot.corners @ data.oMf[leg.foot_frame_id].rotation.T - [0, 0, robot.foot_lift]
        effort -= J.T @ np.append(pushes.sum(axis=0), np.cross(arms, pushes).sum(axis=0))
    effort[6:] += of_drives(robot, v[6:], a[6:])
    return effort


def function(robot):
    count, legs, corners = len(robot.joint_names), len(robot.legs), len(robot.corners)
    q, v, a = (ca.SX.sym(name, count) for name in "qva")
    omega, omega_rate, base, velocity = (ca.SX.sym(name, 3) for name in "wxbv")
    f = ca.SX.sym("f", 3, legs * corners)
    pushes = {leg: [f[:, leg * corners + c] for c in range(corners)] for leg in range(legs)}
    bodies = RigidBodies(robot)
    effort = bodies.inverse_dynamics(q, v, a, omega, omega_rate, base, UP, pushes)
    feet = bodies.feet(q, v, omega, velocity)
    return ca.Function(
        "motion",
        [q, v, a, omega, omega_rate, base, f, velocity],
        [ca.vertcat(effort.force, effort.moment, effort.torque)]
        + [ca.horzcat(*(getattr(foot, name) for foot in feet)) for name in feet[0]._fields],
    )


def test_efforts_are_those_of_pinocchio(robot):
    expressions = function(robot)
    for seed in range(5):
        q, v, a, forces = state(robot, seed)
        # Pinocchio's is a spatial acceleration, in which the base's turning velocity is missing.
        base = a[:3] + np.cross(v[3:6], v[:3]) + [0.0, 0.0, 9.81]
        found = expressions(
            q[7:], v[6:], a[6:], v[3:6], a[3:6], base, forces.reshape(-1, 3).T, v[:3]
        )[0]
        expected = of_pinocchio(robot, q, v, a, forces)
        np.testing.assert_allclose(np.array(found).ravel(), expected, atol=1e-8)


def test_pinocchios_own_rotors_are_those(robot):
    q, v, a, _ = state(robot, 3)
    with_rotors, links = (
        pin.rnea(model, model.createData(), q, v, a) for model in (robot.model, links_alone(robot))
    )
    np.testing.assert_allclose(
        with_rotors - links, [*np.zeros(6), *robot.armature * a[6:]], atol=1e-9
    )


def test_feet_move_as_pinocchios(robot):
    q, v, a, forces = state(robot, 7)
    _, position, velocity, rotation, omega = function(robot)(
        q[7:], v[6:], a[6:], v[3:6], a[3:6], np.zeros(3), forces.reshape(-1, 3).T, v[:3]
    )
    model, data = robot.model, robot.model.createData()
    pin.forwardKinematics(model, data, q, v)
    pin.updateFramePlacements(model, data)
    for k, leg in enumerate(robot.legs):
        moves = pin.getFrameVelocity(model, data, leg.foot_frame_id, pin.LOCAL_WORLD_ALIGNED)
        placed = data.oMf[leg.foot_frame_id]
        found = np.array(rotation)[:, 3 * k : 3 * k + 3]
        np.testing.assert_allclose(found, placed.rotation, atol=1e-10)
        np.testing.assert_allclose(np.array(position)[:, k], placed.translation, atol=1e-10)
        np.testing.assert_allclose(np.array(velocity)[:, k], moves.linear, atol=1e-10)
        np.testing.assert_allclose(np.array(omega)[:, k], moves.angular, atol=1e-10)
