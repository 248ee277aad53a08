"""A mistake in a robot file is one line that says where it is and what would be right."""

import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from llsrbm.errors import InputError, RobotFileError
from llsrbm.robots import load_robot
from llsrbm.robots.schema import RobotFile, read_robot_file, robot_files

ANYMAL = robot_files()["anymal"].read_text()

MISTAKES = {
    "misspelt key": (
        "friction = 0.5",
        "frction = 0.5",
        ['unknown key "limits.frction"', 'did you mean "friction"?', "clearance", "(and 1 more)"],
    ),
    "missing key": (
        "friction = 0.5\n",
        "",
        ['missing key "limits.friction"', "expected: torque, joint_speed, torque_share"],
    ),
    "missing table": ("[timing] ", "[task.timing] ", ["timing"]),
    "angle that is none": (
        "[legs]",
        '[urdf.held]\nneck = "up"\n[legs]',
        ["urdf.held.neck", "valid number", '"up"'],
    ),
    "frame without its place": (
        "[legs]",
        '[urdf.frames]\nsole = { link = "base" }\n[legs]',
        ['missing key "urdf.frames.sole.xyz"', "expected: link, xyz, rpy"],
    ),
    "interval turned round": (
        "distance = [0.26, 0.52]",
        "distance = [0.56, 0.52]",
        ["reach.distance", "exceeds", "[0.56, 0.52]"],
    ),
    "number for an interval": (
        "distance = [0.26, 0.52]",
        "distance = 0.52",
        ["reach.distance", "expected an array", "0.52"],
    ),
    "box turned inside out": (
        "lower = [-0.22, -0.20, -0.56]",
        "lower = [-0.22, 0.30, -0.56]",
        ["reach", "lower exceeds upper along y: 0.3 > 0.2"],
    ),
    "word for a number": ("torque = 40.0", 'torque = "40"', ["limits.torque", "number", '"40"']),
    "negative limit": ("torque = 40.0", "torque = -40.0", ["limits.torque", "greater than 0"]),
    "title of two lines": ('title = "ANYmal B"', 'title = "ANY\\nmal"', ["title", "one line"]),
    "absurd limit": ("torque = 40.0", "torque = 1e300", ["limits.torque", "1e+06", "1e+300"]),
    "absurd place": ("upper = [0.22,", "upper = [1e200,", ["reach.upper", "1e+06", "1e+200"]),
    "absurd angle": (
        "[legs]",
        "[urdf.held]\nneck = 1e300\n[legs]",
        ["urdf.held.neck", "1e+06", "1e+300"],
    ),
    "not a number": ("torque = 40.0", "torque = nan", ["limits.torque", "finite"]),
    "posture of an unknown leg": (
        "LF = [-0.1,",
        "FL = [-0.1,",
        ["posture.FL", "no such leg", "LF, RF, LH, RH"],
    ),
    "posture of a leg missing": ("LF = [-0.1, 0.7, -1.0]\n", "", ["posture.LF: missing"]),
    "example out of the task": (
        "[example]",
        "[example]\nheight = 0.4",
        ["example.height: expected -0.2 to 0.3", "task.height", "0.4"],
    ),
    "two sources of a URDF": (
        'package = "example-robot-data"',
        'package = "example-robot-data"\nfile = "a.urdf"',
        ["urdf", '"package" and "path", or "file"'],
    ),
    "bad name": ('name = "anymal"', 'name = "ANY mal"', ["name", '"ANY mal"']),
    "not TOML": ("[limits]", "[limits", ["not a TOML file", "line"]),
}


def complaint(tmp_path: Path, text: str) -> str:
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(RobotFileError) as caught:
        read_robot_file(path)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(str(path))
    return message


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_is_one_clear_line(tmp_path, mistake):
    right, wrong, expected = MISTAKES[mistake]
    assert right in ANYMAL
    message = complaint(tmp_path, ANYMAL.replace(right, wrong, 1))
    for part in expected:
        assert part in message


def test_file_that_cannot_be_read(tmp_path):
    with pytest.raises(RobotFileError, match=r"nosuch\.toml: cannot be read \(No such file"):
        read_robot_file(tmp_path / "nosuch.toml")
    with pytest.raises(RobotFileError, match="cannot be read"):
        read_robot_file(tmp_path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(RobotFileError, match="UTF-8"):
        read_robot_file(binary)


def test_every_robot_file_is_named_like_the_robot():
    for name, path in robot_files().items():
        assert read_robot_file(path).name == name


# A robot file that a program mangled: whatever one number becomes, it is read or refused.
@given(value=st.one_of(st.integers(), st.floats(), st.text(max_size=5), st.booleans(), st.none()))
def test_any_value_is_accepted_or_refused_by_name(value):
    table = read_robot_file(robot_files()["anymal"]).model_dump()
    table["limits"]["torque"] = value
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if value is None:  # left out: the URDF's
        assert RobotFile.model_validate(table).limits.torque is None
    elif number and 0 < value < float("inf"):
        assert RobotFile.model_validate(table).limits.torque == pytest.approx(value)
    else:
        with pytest.raises(ValueError, match="torque"):
            RobotFile.model_validate(table)


class TestPathsThatAStrangersFileMayName:
    def test_a_device(self):
        with pytest.raises(RobotFileError, match="not a regular file"):
            read_robot_file("/dev/zero")

    def test_a_pipe(self, tmp_path):
        os.mkfifo(tmp_path / "x.toml")
        with pytest.raises(RobotFileError, match="not a regular file"):
            read_robot_file(tmp_path / "x.toml")

    def test_a_large_file(self, tmp_path):
        (tmp_path / "x.toml").write_bytes(b"#" * 1_000_001)
        with pytest.raises(RobotFileError, match="too large for a robot file"):
            read_robot_file(tmp_path / "x.toml")

    def test_tables_without_end(self, tmp_path):
        (tmp_path / "x.toml").write_text("x = " + "[" * 100_000)
        with pytest.raises(RobotFileError, match="nested too deeply"):
            read_robot_file(tmp_path / "x.toml")

    def test_a_null_character(self):
        with pytest.raises(InputError, match="null character"):
            load_robot("a\0.toml")
