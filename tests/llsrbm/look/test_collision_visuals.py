"""Stand-ins by collision shapes: quick, and where the robot is."""

from time import thread_time

import numpy as np
import pytest

from llsrbm.cache import ENVIRONMENT_VARIABLE
from llsrbm.look.collision_visuals import collision_visuals, visuals_at_once
from llsrbm.look.visuals import needs_preparation
from llsrbm.robots import load_robot
from tests.llsrbm.look.standing import standing


@pytest.fixture
def empty_cache(tmp_path, monkeypatch):
    monkeypatch.setenv(ENVIRONMENT_VARIABLE, str(tmp_path))


@pytest.mark.parametrize("name", ["go2", "slider", "g1"])
def test_shapes_are_where_the_robot_stands(name):
    robot = load_robot(name)
    visuals = collision_visuals(robot)
    assert visuals[0].link
    assert len({visual.joint_id for visual in visuals}) == len(visuals)
    for visual in visuals:
        assert visual.faces.max() < len(visual.vertices)
        assert visual.rgb.shape == visual.normals.shape == visual.vertices.shape
        assert np.linalg.norm(visual.normals, axis=1) == pytest.approx(1, abs=0.03)
    points = standing(robot, visuals)
    # Balls rest on the ground: the feet's frames are their middles, or the soles.
    assert points[:, 2].min() == pytest.approx(0.0, abs=0.04)
    for foot in robot.feet:
        assert np.linalg.norm(points - foot, axis=1).min() < 0.09  # a sole: its corners


@pytest.mark.usefixtures("empty_cache")
@pytest.mark.parametrize("name", ["go2"])
def test_with_an_empty_cache_the_shapes_stand_in_at_once(name):
    robot = load_robot(name)
    collision_visuals.cache_clear()
    assert needs_preparation(robot)
    began = thread_time()
    visuals = visuals_at_once(robot)
    assert thread_time() - began < 1.0  # s of this thread alone, on a machine that is busy, too
    assert visuals == collision_visuals(robot)
