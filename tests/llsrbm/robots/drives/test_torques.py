"""Torques that drives give at a speed and what friction takes of them, many instants at once."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from llsrbm.robots import load_robot
from llsrbm.robots.drives.torques import friction_torque, torque_in_direction, torque_range
from llsrbm.robots.drives.variants import with_drives

ROBOT = load_robot("slider")
LIMIT, SPEED = ROBOT.torque_limit, ROBOT.speed_limit


@pytest.mark.parametrize(
    ("share", "driving"), [(0.0, 1.0), (0.7, 1.0), (0.85, 0.5), (1.0, 0.0), (1.2, 0.0)]
)
def test_driving_torque_falls_and_braking_torque_does_not(share, driving):
    speed = np.array([share * SPEED, -share * SPEED])
    torque = np.array([LIMIT, LIMIT])
    np.testing.assert_allclose(
        torque_in_direction(ROBOT, speed, torque), [driving * LIMIT, LIMIT], atol=1e-9
    )
    np.testing.assert_allclose(
        torque_in_direction(ROBOT, speed, -torque), [LIMIT, driving * LIMIT], atol=1e-9
    )


def test_a_drive_that_brakes_takes_back_no_more_power_than_its_file_says():
    power = 0.5 * float((LIMIT * SPEED).min())  # W
    robot, speed = with_drives(ROBOT, regeneration=power), np.linspace(-2, 2, 41)[:, None] * SPEED
    for sign in (1.0, -1.0):
        most = torque_in_direction(robot, speed, sign * LIMIT)
        braking = sign * speed < 0
        np.testing.assert_array_less((most * np.abs(speed))[braking], power * (1 + 1e-9))
        free = torque_in_direction(ROBOT, speed, sign * LIMIT)
        np.testing.assert_array_equal(most[~braking], free[~braking])
        slow = np.abs(speed * LIMIT) < power
        np.testing.assert_array_equal(most[slow], free[slow])


@given(
    share=arrays(float, len(LIMIT), elements=st.floats(-2.5, 2.5)),
    power=st.none() | st.floats(10.0, 5000.0),
)
def test_the_range_of_torques_ends_where_each_direction_does(share, power):
    robot, speed = with_drives(ROBOT, regeneration=power), share * SPEED
    low, high = torque_range(robot, speed)
    np.testing.assert_allclose(high, torque_in_direction(robot, speed, LIMIT))
    np.testing.assert_allclose(low, -torque_in_direction(robot, speed, -LIMIT))


def test_friction_is_odd_and_whole_beyond_a_few_hundredths_of_the_speed():
    speed = np.linspace(0, 1, 401)[:, None] * SPEED
    taken = friction_torque(ROBOT, speed)
    np.testing.assert_array_equal(friction_torque(ROBOT, -speed), -taken)
    assert not taken[0].any()
    coulomb = taken - ROBOT.damping * speed
    assert (np.diff(taken, axis=0) > 0).all()
    assert (coulomb <= ROBOT.friction * (1 + 1e-9)).all()
    fast = speed[:, 0] >= 0.04 * SPEED[0]
    np.testing.assert_allclose(coulomb[fast], ROBOT.friction + 0 * coulomb[fast], rtol=1e-3)
    # At rest it rises to the whole over a hundredth of the largest speed.
    little = 1e-5 * SPEED
    np.testing.assert_allclose(
        friction_torque(ROBOT, little) / little,
        ROBOT.friction / (0.01 * SPEED) + ROBOT.damping,
        rtol=1e-5,
    )
