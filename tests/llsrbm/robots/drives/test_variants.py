"""Robots with other drives: what changes with them, and what stays."""

import numpy as np
import pytest

from llsrbm.errors import InputError
from llsrbm.robots import load_robot
from llsrbm.robots.drives.torques import friction_torque, torque_in_direction
from llsrbm.robots.drives.variants import driven, ideal, with_drives

ROBOT = load_robot("slider")
LIMIT, SPEED = ROBOT.torque_limit, ROBOT.speed_limit


def test_other_drives_give_more_and_the_rest_of_the_robot_is_the_same():
    other = with_drives(ROBOT, torque=1.5, speed=0.5)
    speed = 0.4 * SPEED  # 80 % of what is left of it: a third of the torque is lost there
    np.testing.assert_allclose(torque_in_direction(other, 0 * speed, LIMIT), 1.5 * LIMIT)
    np.testing.assert_allclose(torque_in_direction(other, speed, LIMIT), LIMIT)
    assert (other.mass, other.joint_names) == (ROBOT.mass, ROBOT.joint_names)
    assert other.fit is ROBOT.fit
    assert with_drives(ROBOT, torque=1.5, speed=0.5) is other
    assert with_drives(ROBOT) is ROBOT
    # Its solvers lie elsewhere in the cache: those of the robot itself are not pushed out.
    assert other.name != ROBOT.name


@pytest.mark.parametrize("name", ["slider", "g1"])
def test_ideal_drives_are_the_robot_without_rotors_friction_and_delay(name):
    robot = load_robot(name)
    rotors = robot.model.armature.copy()
    without = ideal(robot)
    assert not without.armature.any()
    assert not without.model.armature.any()
    assert not friction_torque(without, robot.speed_limit).any()
    assert without.drive_delay == 0.0
    assert (without.mass, without.fit) == (robot.mass, robot.fit)
    np.testing.assert_array_equal(without.torque_limit, robot.torque_limit)
    # The robot itself keeps them.
    np.testing.assert_array_equal(robot.model.armature, rotors)
    assert (robot.armature > 0).all()


def test_drives_are_true_or_ideal():
    assert driven(ROBOT, "true") is ROBOT
    assert driven(ROBOT, "ideal") is ideal(ROBOT)
    with pytest.raises(InputError, match='no drives "none"; valid: true, ideal'):
        driven(ROBOT, "none")


def test_stronger_drives_keep_their_rotors_and_friction():
    other = with_drives(ROBOT, torque=1.5)
    for name in ("armature", "friction", "damping"):
        np.testing.assert_array_equal(getattr(other, name), getattr(ROBOT, name))
    assert other.drive_delay == ROBOT.drive_delay
