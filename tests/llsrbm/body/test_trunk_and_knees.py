"""Trunk and knees, against what MuJoCo makes of the same collision shapes."""

import mujoco
import numpy as np
import pytest

from llsrbm.body.trunk_and_knees import knee_joint, trunk_box
from llsrbm.motion.block import Block
from llsrbm.motion.rollout import Disturbance
from llsrbm.motion.surroundings import Surroundings
from llsrbm.robots import load_robot
from llsrbm.simulation.scene import build_scene


def touches(robot, axis, side, place):
    """Whether a wall square to an axis, whose face is at `place` m, touches the trunk."""
    centre = np.zeros(3)
    centre[axis] = place + side * 2.0
    wall = Block("wall", centre, np.full(3, 4.0), yaw=0.0)
    scene = build_scene(robot, Surroundings(-9.0, (wall,)), Disturbance(), 1e-3)
    data = mujoco.MjData(scene.model)
    data.qpos[:7] = 0, 0, 0, 1, 0, 0, 0
    scene.move_blocks(data, 0.0)
    mujoco.mj_forward(scene.model, data)
    touching = data.contact.geom.ravel()
    base = scene.model.jnt_bodyid[0]
    return bool((scene.model.geom_bodyid[touching] == base).any())


@pytest.mark.parametrize("name", ["anymal", "slider"])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_trunk_ends_where_its_box_does(name, axis):
    robot = load_robot(name)
    low, high = trunk_box(robot)[:, axis]
    for side, end in ((-1, low), (1, high)):
        assert touches(robot, axis, side, end - side * 0.002)
        assert not touches(robot, axis, side, end + side * 0.002)


def test_knees():
    knees = {"anymal": 2, "go2": 2, "slider": None, "g1": 3}
    assert {name: knee_joint(load_robot(name)) for name in knees} == knees
