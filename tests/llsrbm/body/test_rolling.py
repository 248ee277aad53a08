"""Where ball feet roll to, against a ball that rolls in small steps under the whole body."""

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.body.rolling import rolled
from llsrbm.request.schedule import Phase, Schedule
from llsrbm.robots import load_robot
from llsrbm.robots.feet import foot_contacts

ROBOT = load_robot("go2")
LEGS = tuple(leg.name for leg in ROBOT.legs)
SCHEDULE = Schedule(
    LEGS,
    (
        Phase("take-off", LEGS, "takeoff"),
        Phase("flight", (), "flight"),
        Phase("landing", LEGS, "landing", place=1),
    ),
)


def turned_about(axis, angles):
    return Rotation.from_rotvec(np.outer(angles, axis)).as_quat(scalar_first=True)


def small_steps(base_quat, angles, steps=200):
    """(L, 2) m: how far each ball rolls, by Pinocchio's angular velocities in small steps."""
    data, way = ROBOT.model.createData(), np.zeros((len(LEGS), 2))
    radius = [contact.radius for contact in foot_contacts(ROBOT)]
    before = None
    for share in np.linspace(0.0, 1.0, steps + 1):
        turn = Rotation.from_quat(base_quat, scalar_first=True)
        between = turn[0] * Rotation.from_rotvec(share * (turn[0].inv() * turn[1]).as_rotvec())
        q = ROBOT.posture.copy()
        q[3:7] = between.as_quat()
        q[7:] = angles[0] + share * (angles[1] - angles[0])
        pin.framesForwardKinematics(ROBOT.model, data, q)
        now = [data.oMf[leg.foot_frame_id].rotation.copy() for leg in ROBOT.legs]
        if before is not None:
            for leg, (new, old) in enumerate(zip(now, before, strict=True)):
                x, y, _ = pin.log3(new @ old.T)
                way[leg] += radius[leg] * np.array([y, -x])
        before = now
    return way


@pytest.mark.parametrize("axis", [(0, 1, 0), (1, 0, 0)], ids=["pitch", "roll"])
def test_a_take_off_rolls_the_feet_on(axis):
    """From knot to knot the body leans by a tenth of a rad, and its knees bend."""
    quats = turned_about(axis, [0.0, 0.1, 0.2, 0.2])
    angles = np.tile(ROBOT.posture[7:], (4, 1))
    angles[1:, ROBOT.leg_joint_index[:, 2]] += 0.1
    away = rolled(ROBOT, angles, quats, SCHEDULE, np.array([0, 0, 1, 2]))
    np.testing.assert_allclose(away[0], 0.0)
    first = small_steps(quats[:2], angles[:2])
    np.testing.assert_allclose(away[1], first, atol=2e-5)
    assert np.abs(first).max() > 1e-3
    second = small_steps(quats[1:3], angles[1:3])
    np.testing.assert_allclose(away[2], first + second, atol=4e-5)


def test_feet_that_have_landed_come_to_stand_in_their_places():
    quats = turned_about((0, 1, 0), [0.0, 0.0, 0.3, 0.1, 0.0])
    angles = np.tile(ROBOT.posture[7:], (5, 1))
    away = rolled(ROBOT, angles, quats, SCHEDULE, np.array([0, 1, 2, 2, 2]))
    np.testing.assert_allclose(away[-1], 0.0, atol=1e-12)
    radius = foot_contacts(ROBOT)[0].radius
    # They roll forward as the body leans forward, and lie behind until it has come back.
    np.testing.assert_allclose(away[2, :, 0], 0.3 * radius, rtol=1e-6)
    np.testing.assert_allclose(away[3, :, 0], 0.1 * radius, rtol=1e-6)


def test_frames_beside_the_middles_of_their_balls_turn_about_these():
    """ANYmal's are 23 mm from them: as the body leans they move otherwise than the balls roll."""
    robot = load_robot("anymal")
    legs = tuple(leg.name for leg in robot.legs)
    schedule = Schedule(
        legs, tuple(Phase(p.name, legs if p.feet else (), p.time, p.place) for p in SCHEDULE)
    )
    quats = turned_about((0, 1, 0), [0.0, 0.0, 0.3, 0.1, 0.0])
    angles = np.tile(robot.posture[7:], (5, 1))
    pose = robot, angles, quats, schedule, np.array([0, 1, 2, 2, 2])
    balls, frames = rolled(*pose), rolled(*pose, frames=True)
    data, from_ball = robot.model.createData(), np.empty((5, 4, 2))
    for k, quat in enumerate(quats):
        q = np.concatenate([robot.posture[:3], np.roll(quat, -1), angles[k]])
        pin.framesForwardKinematics(robot.model, data, q)
        for leg, contact in enumerate(foot_contacts(robot)):
            placed = data.oMf[robot.legs[leg].foot_frame_id]
            from_ball[k, leg] = -(placed.rotation @ contact.centres[0])[:2]
    np.testing.assert_allclose(frames[-1], 0.0, atol=1e-12)
    expected = (from_ball - from_ball[-1])[2:]
    np.testing.assert_allclose((frames - balls)[2:], expected, atol=1e-12)
    assert np.abs(expected).max() > 3e-3


def test_soles_do_not_roll():
    robot = load_robot("slider")
    legs = tuple(leg.name for leg in robot.legs)
    schedule = Schedule(
        legs, tuple(Phase(p.name, legs if p.feet else (), p.time, p.place) for p in SCHEDULE)
    )
    quats = turned_about((0, 1, 0), [0.0, 0.1, 0.2])
    angles = np.tile(robot.posture[7:], (3, 1))
    assert not rolled(robot, angles, quats, schedule, np.array([0, 1, 2])).any()
