"""Links that the controller keeps apart by itself: in MuJoCo, where they go through each other."""

import numpy as np
import pytest

from llsrbm.control.link_bounds import LinkBounds
from llsrbm.control.whole_body import WholeBody
from llsrbm.robots import load_robot
from llsrbm.robots.link_shapes import LinkShapes
from tests.llsrbm.control.floating import floating


def nearest(name, positions):
    """m, the least distance of links in postures of the joints (T, J)."""
    robot = load_robot(name)
    q = np.hstack([np.tile(robot.posture[:7], (len(positions), 1)), positions])
    return LinkShapes.of(robot).least(q)[0]


def closing(name, turn):
    """Joints (J,) with all legs drawn inwards by their first joint that does so."""
    robot = load_robot(name)
    wanted = robot.posture[7:].copy()
    of_leg = 1 if name == "g1" else 0
    for leg, joints in zip(robot.legs, robot.leg_joint_index, strict=True):
        side = np.sign(robot.feet[robot.legs.index(leg), 1])
        wanted[joints[of_leg]] -= side * turn
    return wanted


@pytest.mark.parametrize(("name", "turn"), [("go2", 0.8), ("g1", 0.4)])
def test_links_that_a_task_would_drive_into_each_other_stay_apart(name, turn):
    wanted = closing(name, turn)
    assert nearest(name, floating(name, wanted, 0.0, apart=True)[0]) > 0.0
    assert nearest(name, floating(name, wanted, 0.0)[0]) < -0.005


def test_links_that_are_far_from_each_other_have_no_rows():
    robot = load_robot("anymal")
    body = WholeBody(robot)
    body.update(robot.posture, np.zeros(robot.model.nv))
    rows, least = LinkBounds(robot).rows(body)
    assert rows.shape == (0, len(robot.joint_names))
    assert least.shape == (0,)
