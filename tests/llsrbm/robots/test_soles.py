"""A robot file whose default posture does not stand on its soles is refused."""

import pytest

from llsrbm.errors import RobotFileError
from llsrbm.robots import build_robot, load_robot
from llsrbm.robots.schema import robot_files

PATH = robot_files()["slider"]


def slider_standing(tmp_path, left, right):
    """SLIDER's file with other joint angles."""
    text = PATH.read_text()
    before, rest = text.split("[posture]\n")
    after = rest.split("\n", 2)[2]
    urdf = load_robot("slider").urdf_path.as_posix()
    text = f"{before}[posture]\nleft = {left}\nright = {right}\n{after}"
    path = tmp_path / "mine.toml"
    path.write_text(text.replace("../slider/slider.urdf", urdf))
    return build_robot(path)


def leaning(angle):
    """Legs that lean forward, ankles that keep the soles level."""
    return [0.0, angle, 0.0, 0.0, -angle, 0.0]


def test_a_sole_on_its_edge(tmp_path):
    edge = leaning(-0.02)
    edge[4] += 0.1
    with pytest.raises(RobotFileError, match=r"mine\.toml: posture\.right: .* leans by 0\.100 rad"):
        slider_standing(tmp_path, leaning(-0.02), edge)


def test_a_robot_that_tips_over(tmp_path):
    """Legs 0.69 m long at 0.15 rad: soles 0.1 m behind the hips, 0.07 m from middle to edge."""
    message = r"mine\.toml: posture: the robot tips over, its CoM is 0\.\d+ m outside"
    with pytest.raises(RobotFileError, match=message):
        slider_standing(tmp_path, leaning(0.15), leaning(0.15))


def test_turned_out_feet(tmp_path):
    """Headings are to the left: outwards for the left leg, inwards for the right."""
    turned = leaning(0.0)
    turned[3] = 0.3
    robot = slider_standing(tmp_path, turned, leaning(0.0))
    assert robot.foot_yaw == pytest.approx([0.3, 0.0])
