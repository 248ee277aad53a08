import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.look.visuals import forward_kinematics
from llsrbm.motion.bodies import link_paths
from llsrbm.robots import load_robot


@pytest.fixture(scope="module")
def paths():
    robot = load_robot("anymal")
    yaw = np.linspace(0, 2 * np.pi, 30)
    quat = np.stack([np.cos(yaw / 2), 0 * yaw, 0 * yaw, np.sin(yaw / 2)], axis=1)
    posture = np.tile(robot.posture[7:], (30, 1))
    bodies = forward_kinematics(robot, np.zeros((30, 3)), quat, posture)
    return {path.link: path for path in link_paths(robot, *bodies)}


def test_parents_come_first(paths):
    known = {"world"}
    for path in paths.values():
        assert path.parent in known
        known.add(path.link)


def test_what_turns_with_its_parent_stands_still_in_it(paths):
    thigh = paths["LF_THIGH"]
    assert thigh.moves
    np.testing.assert_allclose(thigh.position, thigh.position[:1].repeat(30, axis=0), atol=1e-12)
    np.testing.assert_allclose(np.abs(np.sum(thigh.quat * thigh.quat[0], axis=1)), 1)
    assert not paths["LF_FOOT"].moves
    assert paths["LF_FOOT"].position.shape == (1, 3)


def test_the_root_turns_in_the_world_without_jumps_of_sign(paths):
    root = paths["base"]
    assert root.parent == "world"
    assert (np.sum(root.quat[1:] * root.quat[:-1], axis=1) > 0.9).all()
    yaw = np.unwrap(Rotation.from_quat(root.quat, scalar_first=True).as_euler("ZYX")[:, 0])
    assert yaw[-1] == pytest.approx(2 * np.pi)
