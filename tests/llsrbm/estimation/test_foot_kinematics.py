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
    places, speeds, turning = (
        each.reshape(len(robot.legs), -1, 3)
        for each in (feet.position, feet.velocity, feet.angular_velocity)
    )
    np.testing.assert_allclose(places.mean(axis=1) - [0, 0, feet.radius], body.foot, atol=1e-12)
    np.testing.assert_allclose(speeds.mean(axis=1), body.foot_velocity, atol=1e-12)
    for corner in range(feet.points):
        np.testing.assert_allclose(turning[:, corner], body.foot_angular_velocity, atol=1e-12)
    # With the base at rest, points that touch the ground are the balls' less what they roll.
    rolling = np.cross(feet.angular_velocity, [0, 0, feet.radius])
    np.testing.assert_allclose(feet.velocity - rolling, body.contact_velocity, atol=1e-12)
    before = feet.position.copy()
    feet.update(q[7:] + 1e-7 * v[6:], v[6:])
    np.testing.assert_allclose((feet.position - before) / 1e-7, feet.velocity, atol=1e-5)


def test_soles_have_corners_and_balls_are_round():
    slider, go2 = load_robot("slider"), load_robot("go2")
    feet = FootKinematics(slider)
    feet.update(slider.posture[7:], np.zeros(12))
    assert feet.points == 4
    np.testing.assert_allclose(np.ptp(feet.position[:4], axis=0)[:2], [0.144, 0.078], atol=1e-3)
    assert FootKinematics(go2).points == 1
    assert FootKinematics(go2).radius == foot_contacts(go2)[0].radius
