"""Thigh and shank against the joints' placements as the URDFs state them."""

import re
from pathlib import Path

import numpy as np
import pytest

from llsrbm.robots import load_robot
from llsrbm.robots.knee import knee_links
from llsrbm.robots.robot import build_robot
from tests.llsrbm.robots.test_robot import ANYMAL

BENCHMARKS = Path(__file__).parents[3] / "benchmarks" / "robots"


def test_anymal():
    """KFE at (0, 0.109, -0.25) of HFE, the foot at (0.1, -0.02, -0.32125) of KFE, axes along y."""
    thigh, shank = knee_links(load_robot("anymal"))
    assert thigh == pytest.approx(0.25)
    assert shank == pytest.approx(np.hypot(0.1, 0.32125))


@pytest.mark.parametrize(
    ("robot", "length"), [("go2", 0.213), (str(BENCHMARKS / "solo12.toml"), 0.16)]
)
def test_links_of_one_length(robot, length):
    assert knee_links(load_robot(robot)) == pytest.approx((length, length))


def test_axes_that_the_urdf_turns():
    """ANYmal C: KFE at (0, 0.1003, -0.285) of HFE, the foot at (0.08795, 0.01305, -0.33797)."""
    thigh, shank = knee_links(load_robot(str(BENCHMARKS / "anymal_c.toml")))
    assert thigh == pytest.approx(0.285)
    assert shank == pytest.approx(np.hypot(0.08795, 0.33797))


def anymal_with(tmp_path, change):
    """ANYmal's file beside a URDF in which `change` was made to every knee joint's text."""
    urdf = load_robot("anymal").urdf_path.read_text()
    urdf, count = re.subn(r'<joint name="\w\w_KFE".*?</joint>', change, urdf, flags=re.DOTALL)
    assert count == 4
    (tmp_path / "robot.urdf").write_text(urdf)
    source = re.search(r"package = .*\npath = .*", ANYMAL)[0]
    path = tmp_path / "mine.toml"
    path.write_text(ANYMAL.replace(source, 'file = "robot.urdf"').replace("0.7, -1.0", "0.0, 0.0"))
    return build_robot(path)


def test_no_knee_of_slider():
    assert knee_links(load_robot("slider")) is None


def test_no_knee_that_slides(tmp_path):
    robot = anymal_with(tmp_path, lambda m: m[0].replace('"revolute"', '"prismatic"'))
    assert knee_links(robot) is None


def test_no_knee_across_the_hip(tmp_path):
    robot = anymal_with(tmp_path, lambda m: re.sub(r'<axis xyz="[^"]*"', '<axis xyz="1 0 0"', m[0]))
    assert knee_links(robot) is None


def test_no_knee_without_a_joint_after_the_hip(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(re.sub(r'hip = "(\w\w)_HFE"', r'hip = "\1_KFE"', ANYMAL))
    assert knee_links(build_robot(path)) is None
