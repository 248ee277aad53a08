"""Which numbers of drives are measured, published or assumed, in words and as data."""

import pytest

from llsrbm.robots import load_robot
from llsrbm.robots.drives.stated import known_drives, known_in_words, stated_drives
from llsrbm.robots.drives.table import JointDrives

NUMBERS = {"armature": 0.01, "friction": 0.2, "damping": 0.1}


def file_of(name, **drives):
    return load_robot(name).file.model_copy(update={"drives": JointDrives(**drives)})


@pytest.mark.parametrize(
    ("name", "drives", "words"),
    [
        ("go2", {}, "rotors, friction, damping, delay assumed"),
        (
            "go2",
            {"armature": 0.01, "friction": 0.2, "known": {"armature": "published"}},
            "rotors published; friction, damping, delay assumed",
        ),
        (
            "go2",
            {**NUMBERS, "known": {"armature": "measured", "damping": "published"}},
            "rotors measured; damping published; friction, delay assumed",
        ),
        (
            "g1",
            {"armature": 0.01, "known": {"armature": "published"}},
            "rotors published; friction, damping, delay, arms' rotors assumed",
        ),
        (
            "g1",
            {"armature": 0.01, "arms": {"armature": 0.003}, "known": {"armature": "published"}},
            "rotors published; friction, damping, delay assumed",
        ),
    ],
)
def test_in_words(name, drives, words):
    assert known_in_words(file_of(name, **drives)) == words


@pytest.mark.parametrize(("count", "arms"), [(20, "measured"), (19, "assumed")])
def test_arms_are_measured_where_every_joint_has_a_number_of_its_own(count, arms):
    joints = {joint: {"armature": 0.01} for joint in load_robot("g1").joint_names[:count]}
    known = known_drives(file_of("g1", joints=joints, known={"armature": "measured"}))
    assert known["armature"] == "measured"
    assert known["arms.armature"] == arms


def test_as_data():
    robot = load_robot("go2")
    stated = stated_drives(robot)
    assert stated["joints"] == list(robot.joint_names)
    assert stated["armature"] == robot.armature.tolist()
    assert stated["delay"] == robot.drive_delay
    assert stated["known"].keys() == {"armature", "friction", "damping", "delay"}
