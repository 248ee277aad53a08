"""Bodies in many postures at once, against Pinocchio one by one."""

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.robots import load_robot
from llsrbm.robots.placements import placements, pushes, velocities

POSTURES = 4


@pytest.fixture(params=["go2", "slider", "g1"])  # joints that turn, slide, and a trunk that turns
def moving(request):
    """Model, postures and velocities."""
    model, rng = load_robot(request.param).model, np.random.default_rng(3)
    steps = rng.normal(size=(POSTURES, model.nv))
    q = np.array([pin.integrate(model, pin.neutral(model), step) for step in steps])
    return model, q, rng.normal(size=(POSTURES, model.nv))


def test_places_and_velocities_are_those_of_pinocchio(moving):
    model, q, v = moving
    data, placed = model.createData(), placements(model, q)
    moved = velocities(model, placed, v)
    for k in range(POSTURES):
        pin.forwardKinematics(model, data, q[k], v[k])
        for joint in range(1, model.njoints):
            place = data.oMi[joint]
            twist = pin.getVelocity(model, data, joint, pin.LOCAL_WORLD_ALIGNED)
            expected = (place.rotation, place.translation, twist.linear, twist.angular)
            for found, truth in zip((*placed, *moved), expected, strict=True):
                np.testing.assert_allclose(found[k, joint], truth, atol=1e-12)


def test_pushes_do_the_work_of_forces(moving):
    """J^T f by Pinocchio's Jacobian of the joint that is pushed."""
    model, q, _ = moving
    data, joint = model.createData(), model.njoints - 1
    force, moment = np.random.default_rng(4).normal(size=(2, POSTURES, 3))
    found = pushes(model, placements(model, q), joint, force, moment)
    for k in range(POSTURES):
        pin.computeJointJacobians(model, data, q[k])
        J = pin.getJointJacobian(model, data, joint, pin.WORLD)
        np.testing.assert_allclose(found[k], J.T @ np.append(force[k], moment[k]), atol=1e-12)
