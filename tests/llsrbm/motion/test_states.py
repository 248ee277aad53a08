"""Contacts and velocities out of states, against motions in which they are known."""

import mujoco
import numpy as np
import pytest

from llsrbm.motion.whole_body import motion_of_states, standing, velocities, whole_body_motion
from tests.llsrbm.formats.jumps import planned, simulated


@pytest.mark.parametrize("made", [planned, simulated])
@pytest.mark.parametrize("robot", ["anymal", "slider", "go2"])
def test_feet_stand_when_the_plan_or_the_simulator_says_so(made, robot):
    motion = whole_body_motion(made(robot), fps=60)
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


def turning(time):
    """qpos and qvel of a body that turns about all axes, in MuJoCo's convention."""
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><freejoint/><geom size='1'/></body></worldbody></mujoco>"
    )
    qvel = np.stack(
        [time, np.cos(time), 2 + 0 * time, np.sin(time), 3 * np.cos(2 * time), 1 - time], axis=1
    )
    fine = 400
    qpos, path = np.array([0, 0, 0, 1.0, 0, 0, 0]), []
    for k, t in enumerate(time):
        path.append(qpos.copy())
        if k + 1 < len(time):
            h = (time[k + 1] - t) / fine
            for i in range(fine):
                at = t + (i + 0.5) * h
                v = [at, np.cos(at), 2, np.sin(at), 3 * np.cos(2 * at), 1 - at]
                mujoco.mj_integratePos(model, qpos, np.array(v, dtype=float), h)
    return np.array(path), qvel


@pytest.mark.parametrize("even", [True, False])
def test_of_the_second_order(even):
    errors = []
    for count in (21, 41):
        time = np.linspace(0, 1, count)
        time = time if even else time + 0.05 * np.sin(2 * np.pi * time)
        qpos, qvel = turning(time)
        errors.append(np.abs(velocities(time, qpos) - qvel).max())
    assert errors[1] < errors[0] / 3.5
    assert errors[1] < 0.01


def test_signs_of_quaternions_do_not_matter():
    time = np.linspace(0, 1, 21)
    qpos, _ = turning(time)
    flipped = qpos.copy()
    flipped[::2, 3:7] *= -1
    np.testing.assert_allclose(velocities(time, flipped), velocities(time, qpos), atol=1e-12)
