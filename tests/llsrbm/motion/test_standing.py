"""Which feet stand, told from motions in which it is known."""

from __future__ import annotations

import numpy as np
import pytest

from llsrbm.motion.standing import standing
from llsrbm.motion.whole_body import motion_of_states, whole_body_motion
from tests.llsrbm.formats.jumps import planned, simulated

JUMPS = [("anymal", 2.6, 0.0), ("anymal", 0.0, 0.2), ("slider", 0.0, 0.1), ("go2", 3.1, 0.0)]


@pytest.mark.parametrize("made", [planned, simulated])
@pytest.mark.parametrize(("robot", "twist", "height"), JUMPS)
def test_feet_stand_when_the_plan_or_the_simulator_says_so(made, robot, twist, height):
    motion = whole_body_motion(made(robot, twist, height), fps=60)
    told = motion_of_states(motion.robot, "x", motion.time, motion.qpos, motion.qvel, 60)
    assert 0.5 < motion.contact.mean() < 0.95
    assert (told.contact == motion.contact).mean() > 0.98


def test_the_top_of_a_flight_is_not_standing():
    time = np.arange(0, 1.6, 0.01)
    velocity = np.where((time > 0.5) & (time < 1.1), 9.81 * (0.8 - time), 0.0)
    height = np.cumsum(velocity) * 0.01
    stands = standing(time, np.abs(velocity)[:, None], height[:, None])[:, 0]
    np.testing.assert_array_equal(stands, (time <= 0.5) | (time >= 1.1))


def test_a_foot_that_slips_on_the_ground_stands_and_one_that_sweeps_over_it_does_not():
    time = np.arange(0, 1.0, 0.02)
    speed = np.select([time < 0.3, time < 0.4, time < 0.7], [0.0, 0.25, 2.0], 0.0)
    stands = standing(time, speed[:, None], np.zeros((len(time), 1)))[:, 0]
    np.testing.assert_array_equal(stands, speed < 1.0)


def test_feet_that_never_rest():
    time = np.arange(0, 1.0, 0.02)
    assert not standing(time, np.full((50, 2), 1.0), np.zeros((50, 2))).any()
