"""Postures of a whole motion, checked with Pinocchio, which takes no part in finding them."""

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.body.postures import joint_speeds, solve_postures
from llsrbm.errors import InputError
from llsrbm.robots import load_robot

EVERY_ROBOT = ["anymal", "slider"]


class Motion:
    """A smooth turning hop with the feet drawn in on the way, as functions of time in 0..1 s.

    Soles are level and turn half of what the body turns, to and fro.
    """

    def __init__(self, robot, yaw=1.57, forward=0.3, tuck=0.3):
        self.robot, self.yaw, self.forward, self.tuck = robot, yaw, forward, tuck
        self.size = robot.com[2]

    def turn(self, t):
        return pin.exp3(
            np.array(
                [0.08 * np.sin(5 * t), 0.1 * np.sin(6 * t), self.yaw * (1 - np.cos(np.pi * t)) / 2]
            )
        )

    def com(self, t):
        hop = 0.1 * np.sin(np.pi * t) ** 2
        return self.robot.com + self.size * np.array([self.forward * t, 0.05 * np.sin(4 * t), hop])

    def feet(self, t):
        drawn = 1 - self.tuck * np.exp(-(((t - 0.5) / 0.15) ** 2))
        relative = (self.robot.feet - self.robot.com) * drawn * np.array([1, 1, 0.97])
        return self.com(t) + relative @ self.turn(t).T

    def headings(self, t):
        middle = self.yaw * (1 - np.cos(np.pi * t)) / 4
        return middle + 0.3 * np.sin(7 * t + np.arange(len(self.robot.legs)))

    def soles(self, times):
        """(K, L, 4), or nothing for points."""
        if self.robot.foot_coordinates == 3:
            return None
        half = np.array([self.headings(t) for t in times]) / 2
        return np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=-1)

    def sample(self, times):
        quats = np.array([pin.Quaternion(self.turn(t)).coeffs()[[3, 0, 1, 2]] for t in times])
        return (
            np.array([self.com(t) for t in times]),
            quats,
            np.array([self.feet(t) for t in times]),
        )


def configuration(postures, quats, k):
    """Pinocchio's q."""
    return np.concatenate(
        [postures.base_position[k], quats[k, 1:], quats[k, :1], postures.joint_position[k]]
    )


@pytest.mark.parametrize("name", EVERY_ROBOT)
def test_com_attitude_and_feet_are_where_they_shall_be(name):
    robot = load_robot(name)
    motion, times = Motion(robot), np.linspace(0, 1, 49)
    com, quat, feet = motion.sample(times)
    postures = solve_postures(robot, com, quat, feet, motion.soles(times))
    assert postures.residual_m.max() < 1e-6
    data = robot.model.createData()
    for k in range(49):
        q = configuration(postures, quat, k)
        np.testing.assert_allclose(pin.centerOfMass(robot.model, data, q), com[k], atol=1e-9)
        pin.updateFramePlacements(robot.model, data)
        for i, leg in enumerate(robot.legs):
            found = data.oMf[leg.foot_frame_id]
            lowest = found.translation - [0, 0, robot.foot_lift]
            np.testing.assert_allclose(lowest, feet[k, i], atol=1e-6)
            if robot.foot_coordinates > 3:
                level = pin.rpy.rpyToMatrix(0, 0, motion.headings(times[k])[i])
                np.testing.assert_allclose(found.rotation, level, atol=1e-5)
    assert np.abs(np.diff(postures.joint_position, axis=0)).max() < 0.5


@pytest.mark.parametrize("name", ["anymal", "slider"])
def test_standing_gives_the_default_posture(name):
    robot = load_robot(name)
    level = np.tile([1.0, 0, 0, 0], (1, len(robot.legs), 1))
    postures = solve_postures(robot, robot.com[None], [[1, 0, 0, 0]], robot.feet[None], level)
    np.testing.assert_allclose(postures.joint_position[0], robot.posture[7:], atol=1e-6)
    np.testing.assert_allclose(postures.base_position[0], robot.base_position, atol=1e-6)


def test_a_foot_out_of_reach_is_reported_and_spoils_nothing_else():
    robot = load_robot("anymal")
    com, quat, feet = Motion(robot).sample(np.linspace(0, 1, 49))
    wanted = feet.copy()
    wanted[20:24, 0, 2] -= 0.5
    postures = solve_postures(robot, com, quat, wanted)
    clean = solve_postures(robot, com, quat, feet)
    assert (postures.residual_m[20:24] > 0.05).all()
    assert (postures.residual_m[20:24] < 0.5).all()
    others = np.r_[:20, 24:49]
    assert postures.residual_m[others].max() < 1e-6
    np.testing.assert_allclose(
        postures.joint_position[others], clean.joint_position[others], atol=1e-5
    )
    # Even there the CoM is exact: only feet are given up.
    data = robot.model.createData()
    found = pin.centerOfMass(robot.model, data, configuration(postures, quat, 21))
    np.testing.assert_allclose(found, com[21], atol=1e-9)


def test_soles_need_their_attitude():
    robot = load_robot("slider")
    com, quat, feet = Motion(robot).sample(np.linspace(0, 1, 3))
    with pytest.raises(InputError, match="foot_quat is missing: the feet of slider are not points"):
        solve_postures(robot, com, quat, feet)
    joints = np.tile(robot.posture[7:], (3, 1))
    with pytest.raises(InputError, match="foot_angular_velocity is missing"):
        joint_speeds(robot, joints, quat, com, com, feet)


@pytest.mark.parametrize("name", EVERY_ROBOT)
def test_joint_speeds_are_the_motions(name):
    """Against central differences of the postures, and against Pinocchio's velocity of the feet."""
    robot = load_robot(name)
    motion, times, h = Motion(robot), np.linspace(0.05, 0.95, 19), 1e-4
    com, quat, feet = motion.sample(times)
    here = solve_postures(robot, com, quat, feet, motion.soles(times))
    after, before = ((*motion.sample(times + dt), motion.soles(times + dt)) for dt in (h, -h))
    com_velocity = (after[0] - before[0]) / (2 * h)
    foot_velocity = (after[2] - before[2]) / (2 * h)
    omega = np.array([pin.log3(motion.turn(t + h) @ motion.turn(t - h).T) / (2 * h) for t in times])
    headings = [np.array([motion.headings(t + dt) for t in times]) for dt in (h, -h)]
    foot_omega = ((headings[0] - headings[1]) / (2 * h))[..., None] * [0.0, 0.0, 1.0]
    speeds = joint_speeds(
        robot, here.joint_position, quat, omega, com_velocity, foot_velocity, foot_omega
    )
    differences = (
        solve_postures(robot, *after).joint_position - solve_postures(robot, *before).joint_position
    ) / (2 * h)
    np.testing.assert_allclose(speeds, differences, atol=2e-3)

    data = robot.model.createData()
    for k in range(len(times)):
        q = configuration(here, quat, k)
        R = motion.turn(times[k])
        base_velocity = (
            solve_postures(robot, *after).base_position[k]
            - solve_postures(robot, *before).base_position[k]
        ) / (2 * h)
        v = np.concatenate([R.T @ base_velocity, R.T @ omega[k], speeds[k]])
        pin.forwardKinematics(robot.model, data, q, v)
        for i, leg in enumerate(robot.legs):
            velocity = pin.getFrameVelocity(
                robot.model, data, leg.foot_frame_id, pin.LOCAL_WORLD_ALIGNED
            )
            np.testing.assert_allclose(velocity.linear, foot_velocity[k, i], atol=2e-3)
            if robot.foot_coordinates > 3:
                np.testing.assert_allclose(velocity.angular, foot_omega[k, i], atol=2e-3)
        if k == 3:
            break
