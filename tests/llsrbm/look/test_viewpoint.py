import numpy as np
import pytest

from llsrbm.look.visuals import viewpoint
from llsrbm.robots import load_robot


@pytest.mark.parametrize("name", ["go2", "slider", "g1"])
def test_a_robot_is_seen_whole_and_not_small(name):
    """Feet and hips in the middle of the picture, from as far as the robot is large."""
    robot = load_robot(name)
    camera, target = viewpoint(robot)
    seen = (target - camera) / np.linalg.norm(target - camera)
    points = np.vstack([robot.feet, robot.base_position + robot.hips, robot.com])
    rays = points - camera
    off = np.arccos(rays @ seen / np.linalg.norm(rays, axis=1))
    assert np.degrees(off).max() < 30
    assert np.degrees(off[: len(robot.feet)]).max() > 8
    assert camera[2] > target[2] > 0
