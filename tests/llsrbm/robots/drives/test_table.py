"""The table [drives] of robot files: what it refuses, and what it assumes where it is silent."""

import numpy as np
import pytest

from llsrbm.robots import load_robot
from llsrbm.robots.schema import robot_files
from tests.llsrbm.robots.edited import with_table
from tests.llsrbm.robots.mistakes import check_one_clear_line


def robot_with(path, drives, robot="go2"):
    path.write_text(with_table(robot, "drives", drives))
    return load_robot(str(path))


@pytest.mark.parametrize(
    ("robot", "drives", "expected"),
    [
        (
            "go2",
            "armature = [0.01, 0.02]",
            ["drives.armature: expected one number, or 3, one a joint (FL_hip", "got 2"],
        ),
        ("go2", "damping = []", ["drives.damping"]),
        ("g1", "arms.friction = [0.1, 0.1]", ["drives.arms.friction: expected one", "got 2"]),
        ("go2", "arms.friction = 0.1", ["drives.arms.friction", "no arms; expected none"]),
        (
            "go2",
            "joints.FL_calf.armature = 0.01",
            ["drives.joints.FL_calf: no such joint", "FL_calf_joint"],
        ),
        ("go2", "joints.FL_calf_joint.armour = 0.01", ["drives.joints.FL_calf_joint.armour"]),
        ("go2", 'known.friction = "measured"', ["known.friction: expected friction beside it"]),
        ("go2", 'friction = 0.2\nknown.friction = "guessed"', ["drives.known.friction"]),
        ("go2", "friction = -0.2", ["drives.friction"]),
        ("go2", "delay = -0.001", ["drives.delay"]),
        ("go2", "spread = 1.0", ["drives.spread"]),
        ("go2", "friction_range = [2.0, 0.5]", ["drives.friction_range"]),
    ],
)
def test_a_mistake_is_one_clear_line(tmp_path, robot, drives, expected):
    check_one_clear_line(tmp_path / "mine.toml", with_table(robot, "drives", drives), expected)


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_what_is_left_out_is_assumed_from_the_drives_limits(tmp_path, name):
    robot = robot_with(tmp_path / "mine.toml", "", name)
    np.testing.assert_allclose(robot.armature, 2e-4 * robot.torque_limit)
    np.testing.assert_allclose(robot.friction, 0.01 * robot.torque_limit)
    np.testing.assert_allclose(robot.damping * robot.speed_limit, 0.01 * robot.torque_limit)
    assert robot.drive_delay == 0.001


def test_numbers_are_of_all_joints_of_a_list_or_of_one_joint(tmp_path):
    drives = (
        "armature = [0.1, 0.2, 0.3]\nfriction = 0.4\njoints.RL_thigh_joint.armature = 0.5\n"
        'joints.FR_hip_joint.damping = 0.6\nknown.damping = "measured"'
    )
    robot = robot_with(tmp_path / "mine.toml", drives)
    kinds = {"hip": 0.1, "thigh": 0.2, "calf": 0.3}
    for name, armature in zip(robot.joint_names, robot.armature, strict=True):
        expected = 0.5 if name == "RL_thigh_joint" else kinds[name.split("_")[1]]
        assert armature == expected
    assert set(robot.friction) == {0.4}
    own = robot.joint_names.index("FR_hip_joint")
    assert robot.damping[own] == 0.6
    np.testing.assert_allclose(
        np.delete(robot.damping * robot.speed_limit, own),
        np.delete(0.01 * robot.torque_limit, own),
    )
    # What the file states is what bodies are made of.
    np.testing.assert_array_equal(robot.model.armature[6:], robot.armature)


def test_every_robots_rotors_are_in_its_model():
    for name in robot_files():
        robot = load_robot(name)
        np.testing.assert_array_equal(robot.model.armature, [*np.zeros(6), *robot.armature])
        assert (robot.armature > 0).all()
