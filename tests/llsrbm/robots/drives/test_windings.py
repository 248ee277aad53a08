"""Electrical numbers of robot files."""

import numpy as np
import pytest

from llsrbm.robots import load_robot
from llsrbm.robots.drives.windings import Windings
from tests.llsrbm.robots.edited import with_table
from tests.llsrbm.robots.mistakes import check_one_clear_line

LEGS = f"torque_constant = {[0.5] * 6}\nresistance = 0.2\nheat = {[40.0] * 6}\n"
TABLE = "drives.electrical"


def test_legs_and_arms_have_their_own(tmp_path):
    path = tmp_path / "mine.toml"
    arms = f"[{TABLE}.arms]\ntorque_constant = 0.1\nresistance = 0.3\n"
    path.write_text(with_table("g1", TABLE, LEGS + arms))
    robot = load_robot(str(path))
    windings = Windings.of(robot)
    legs, arms = robot.leg_joint_index.ravel(), robot.arm_joint_index
    assert len(legs) + len(arms) == len(robot.joint_names)
    assert set(windings.torque_constant[legs]) == {0.5}
    assert set(windings.torque_constant[arms]) == {0.1}
    assert set(windings.resistance[arms]) == {0.3}
    assert set(windings.heat[legs]) == {40.0}
    assert np.isinf(windings.heat[arms]).all()
    assert Windings.of(load_robot("g1")) is None


@pytest.mark.parametrize(
    ("robot", "table", "expected"),
    [
        ("g1", LEGS, ["drives.electrical.torque_constant", "drives.electrical.arms"]),
        ("go2", LEGS, ["drives.electrical.torque_constant", "or 3", "got 6"]),
        ("go2", "torque_constant = 0.5", ["resistance"]),
        (
            "go2",
            "torque_constant = 0.5\nresistance = 0.2\ncurrent = 30.0",
            ["drives.electrical", "expected voltage"],
        ),
    ],
)
def test_a_mistake_is_one_clear_line(tmp_path, robot, table, expected):
    check_one_clear_line(tmp_path / "mine.toml", with_table(robot, TABLE, table), expected)
