"""Delay and limits of the drives."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from llsrbm.robots import load_robot
from llsrbm.simulation.world import Drives

ROBOT = load_robot("anymal")
TORQUE, SPEED = ROBOT.file.limits.torque, ROBOT.file.limits.joint_speed
JOINTS = len(ROBOT.joint_names)


@given(
    arrays(float, JOINTS, elements=st.floats(-3 * TORQUE, 3 * TORQUE)),
    arrays(float, JOINTS, elements=st.floats(-2 * SPEED, 2 * SPEED)),
)
def test_what_is_applied(torque, speed):
    applied, limit = Drives(ROBOT, 0).limited(torque, speed)
    for wanted, given_, most, w in zip(torque, applied, limit, speed, strict=True):
        expected = TORQUE
        if wanted * w > 0:
            expected = TORQUE * min(1.0, max(0.0, (SPEED - abs(w)) / (0.3 * SPEED)))
        if wanted != 0:
            assert most == pytest.approx(expected, abs=1e-9)
        assert given_ == pytest.approx(np.sign(wanted) * min(abs(wanted), expected), abs=1e-9)


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_torques_arrive_late(delay):
    drives = Drives(ROBOT, delay)
    commands = [np.full(JOINTS, float(k)) for k in range(10)]
    for _ in range(2):  # the second time after a reset
        arrived = [drives.arriving(command)[0] for command in commands]
        assert arrived == [max(0, k - delay) for k in range(10)]
        drives.reset()
