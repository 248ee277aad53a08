"""Feet in the base: against the controller's model, and finite differences."""

import numpy as np
import pytest

from llsrbm.control.whole_body import WholeBody
from llsrbm.estimation.foot_kinematics import FootKinematics
from llsrbm.robots import load_robot
from llsrbm.robots.feet import foot_contacts


@pytest.mark.parametrize("name", ["go2", "slider"])
def test_feet_are_where_the_controllers_model_has_them(name):
    robot, rng = load_robot(name), np.random.default_rng(0)
    feet, body = FootKinematics(robot), WholeBody(robot)
    q, v = robot.posture.copy(), np.zeros(robot.model.nv)
    q[:7] = [0, 0, 0, 0, 0, 0, 1]
    q[7:] += 0.1 * rng.standard_normal(len(q) - 7)
    v[6:] = rng.standard_normal(len(v) - 6)
    feet.update(q[7:], v[6:])
    body.update(q, v)
    np.testing.assert_allclose(feet.position - [0, 0, feet.radius], body.foot, atol=1e-12)
    np.testing.assert_allclose(feet.velocity, body.foot_velocity, atol=1e-12)
    np.testing.assert_allclose(feet.angular_velocity, body.foot_angular_velocity, atol=1e-12)
    before = feet.position.copy()
    feet.update(q[7:] + 1e-7 * v[6:], v[6:])
    np.testing.assert_allclose((feet.position - before) / 1e-7, feet.velocity, atol=1e-5)


def test_soles_are_long_and_balls_are_round():
    slider, go2 = (FootKinematics(load_robot(name)) for name in ("slider", "go2"))
    assert slider.half_length == pytest.approx(np.hypot(0.072, 0.039))
    assert go2.half_length == 0
    assert go2.radius == foot_contacts(load_robot("go2"))[0].radius
