"""Feet, shanks and knees of a pose against Pinocchio."""

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest

from llsrbm.body.trunk_and_knees import knee_joint
from llsrbm.planning.whole_body import legs
from llsrbm.planning.whole_body.leg_pose import leg_pose
from llsrbm.planning.whole_body.limbs import limbs_of
from llsrbm.robots import load_robot
from llsrbm.robots.feet import foot_contacts
from tests.llsrbm.planning.whole_body.moving import moving

AHEAD, UP = ca.DM([1.0, 0.0]), (0.0, 0.0, 1.0)


def seen(robot, state):
    """Legs as numbers."""
    found = []
    for limb in limbs_of(robot)[: len(robot.legs)]:
        own = list(limb.joints)
        base = [state[name] for name in ("position", "quat", "velocity", "omega")]
        joints = [state[name][own] for name in ("joint_position", "joint_velocity")]
        pose = leg_pose(limb.kind).value(
            np.concatenate([*base, *joints]), np.append(limb.numbers, UP)
        )
        radius = foot_contacts(robot)[0].radius
        found.append(legs.Leg.of(limb.kind, ca.SX(pose), radius))
    return found, lambda x: np.array(ca.evalf(ca.SX(x))).squeeze()


@pytest.mark.parametrize("name", ["anymal", "slider", "g1"])
def test_balls_are_where_pinocchio_has_them_and_move_as_it_says(name):
    robot = load_robot(name)
    state, q, v = moving(robot, 1)
    found, number = seen(robot, state)
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, q, v)
    pin.updateFramePlacements(robot.model, data)
    for leg, contact, own in zip(robot.legs, foot_contacts(robot), found, strict=True):
        frame, axes = leg.foot_frame_id, pin.LOCAL_WORLD_ALIGNED
        placed, twist = data.oMf[frame], pin.getFrameVelocity(robot.model, data, frame, axes)
        np.testing.assert_allclose(number(own.foot), placed.translation, atol=1e-9)
        if robot.file.foot.is_point:
            arm = placed.act(contact.centres[0]) - [0, 0, contact.radius] - placed.translation
            slides = twist.linear + np.cross(twist.angular, arm)
            np.testing.assert_allclose(number(own.slides), slides, atol=1e-9)
        else:
            np.testing.assert_allclose(number(own.velocity), twist.linear, atol=1e-9)
        for middle, ball in zip(contact.centres, own.balls, strict=True):
            np.testing.assert_allclose(number(ball), placed.act(middle), atol=1e-9)
        knee = knee_joint(robot)
        if knee is not None:
            expected = data.oMi[leg.joint_ids[knee]].translation
            np.testing.assert_allclose(number(own.knee), expected, atol=1e-9)


def test_a_leaning_shanks_ball_stands_where_its_frame_is_not():
    """ANYmal's balls are 23 mm above their frames: 0.8 rad of lean lower them by 12."""
    robot = load_robot("anymal")
    state = {
        "position": robot.base_position,
        "quat": np.array([1.0, 0.0, 0.0, 0.0]),
        "joint_position": robot.posture[7:],
        "velocity": np.zeros(3),
        "omega": np.zeros(3),
        "joint_velocity": np.zeros(len(robot.joint_names)),
    }
    off = []
    for lean in (0.0, -0.8):
        half = lean / 2
        state["quat"] = np.array([np.cos(half), 0.0, np.sin(half), 0.0])
        found, number = seen(robot, state)
        leg = found[0]
        place = number(leg.foot) - [0.0, 0.0, robot.foot_lift]
        ground = legs.Ground(ca.DM(place), AHEAD, ca.DM.eye(3), ca.DM.zeros(2), AHEAD)
        [offset] = legs.off_place(leg, ground)
        off.append(number(offset))
    np.testing.assert_allclose(off[0], 0.0, atol=1e-4)
    np.testing.assert_allclose(off[1][:2], 0.0, atol=1e-9)
    assert abs(off[1][2] + 0.0116) < 5e-4
