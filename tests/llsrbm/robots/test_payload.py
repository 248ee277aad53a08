"""A point mass on the trunk, against Pinocchio and MuJoCo."""

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.errors import InputError
from llsrbm.mechanics import skew
from llsrbm.motion.rollout import Disturbance
from llsrbm.motion.surroundings import Surroundings
from llsrbm.robots import load_robot
from llsrbm.robots.payload import with_payload
from llsrbm.simulation.scene import build_scene

MASS, PLACE = 4.0, np.array([0.1, -0.03, 0.08])


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_the_mass_matrix_has_a_point_mass_more(name):
    """M + m J^T J, J of the point's velocity, in a posture of no order."""
    robot = load_robot(name)
    loaded = with_payload(robot, (MASS, *PLACE))
    q = pin.integrate(robot.model, robot.posture, np.linspace(-0.3, 0.4, robot.model.nv))
    before, after = (
        pin.crba(model, model.createData(), q) for model in (robot.model, loaded.model)
    )
    before, after = (np.triu(M) + np.triu(M, 1).T for M in (before, after))
    J = np.hstack([np.eye(3), -skew(PLACE), np.zeros((3, robot.model.nv - 6))])
    np.testing.assert_allclose(after, before + MASS * J.T @ J, atol=1e-9)


def test_what_is_said_of_the_robot_agrees():
    robot = load_robot("go2")
    loaded = with_payload(robot, (MASS, *PLACE))
    point = robot.base_position + PLACE  # the base is level in the default posture
    com = (robot.mass * robot.com + MASS * point) / (robot.mass + MASS)
    assert loaded.mass == pytest.approx(robot.mass + MASS)
    np.testing.assert_allclose(loaded.com, com, atol=1e-12)
    arm, reduced = point - robot.com, MASS * robot.mass / (robot.mass + MASS)
    more = reduced * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    np.testing.assert_allclose(loaded.inertia, robot.inertia + more, atol=1e-9)
    legs = loaded.posture[7:][loaded.leg_joint_index]
    np.testing.assert_allclose(loaded.chains.motion(legs).com, com - robot.base_position, atol=1e-9)
    assert loaded.fit.total_mass == loaded.mass
    assert loaded.fit.trunk_mass == pytest.approx(robot.fit.trunk_mass + MASS)
    assert with_payload(robot, (MASS, *PLACE)) is loaded
    assert with_payload(robot, ()) is robot


def test_mujoco_simulates_it():
    robot = load_robot("go2")
    loaded = with_payload(robot, (MASS, *PLACE))
    masses = [
        build_scene(each, Surroundings(0.0, ()), Disturbance(), 1e-3).model.body_mass.sum()
        for each in (robot, loaded)
    ]
    assert masses[1] - masses[0] == pytest.approx(MASS, rel=1e-9)


def test_more_than_half_of_the_robot_is_refused():
    robot = load_robot("go2")
    with pytest.raises(InputError, match=r"payload: 9 kg; go2 takes up to 8\.04"):
        with_payload(robot, (9.0, 0.0, 0.0, 0.0))
