"""Tables of motion references, read back as their consumers read them."""

import json
from pathlib import Path

import numpy as np
import pytest

import llsrbm
from llsrbm.errors import FileFormatError
from llsrbm.formats import export
from llsrbm.motion.whole_body import whole_body_motion
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import check_frames, planned, same_attitude, simulated


@pytest.fixture(scope="module")
def file(name, tmp_path_factory):
    path = tmp_path_factory.mktemp("unitree") / "jump.csv"
    export(simulated(name), path, format="unitree-csv", fps=50)
    return path


@pytest.fixture(scope="module")
def rows(file):
    return np.loadtxt(file, delimiter=",")  # as mjlab's and BeyondMimic's converters do


@pytest.fixture
def copied(tmp_path):
    """A file of one's own to damage."""
    path = tmp_path / "jump.csv"
    export(planned("anymal"), path, format="unitree-csv")
    return path


def beside(path: Path) -> Path:
    return path.with_name(path.name + ".meta.json")


def test_rows_are_the_simulators_states(name, rows):
    assert rows.shape[1] == 7 + 12
    joints = load_robot(name).joint_names
    check_frames(name, 50, rows[:, :3], rows[:, [6, 3, 4, 5]], rows[:, 7:], joints)


def test_what_stands_beside(name, file):
    told = json.loads(beside(file).read_text())
    robot = load_robot(name)
    assert told["fps"] == 50
    assert told["quaternion_order"] == "xyzw"
    assert told["joint_order"] == list(robot.joint_names)
    assert told["columns"] == ["x", "y", "z", "qx", "qy", "qz", "qw", *robot.joint_names]
    units = dict(zip(told["columns"], told["column_units"], strict=True))
    assert units["x"] == "m"
    for joint in robot.joint_names:  # only SLIDER's
        assert units[joint] == ("m" if joint.endswith("slide") else "rad")
    assert told["request"]["twist"] == planned(name).jump.twist


def test_30_frames_a_second_unless_asked_otherwise(copied):
    plan = planned("anymal")
    assert json.loads(beside(copied).read_text())["fps"] == 30
    assert len(copied.read_text().splitlines()) == int(np.ceil(plan.duration * 30 - 1e-6)) + 1


def test_opened(name, file):
    motion = llsrbm.load_motion(file, robot=name)
    truth = whole_body_motion(simulated(name), 50)
    assert motion.origin == "unitree-csv"
    assert motion.fps == 50
    np.testing.assert_allclose(motion.time, truth.time, atol=1e-9)
    np.testing.assert_allclose(motion.qpos[:, :3], truth.qpos[:, :3], atol=1e-6)
    np.testing.assert_allclose(motion.qpos[:, 7:], truth.qpos[:, 7:], atol=1e-6)
    same_attitude(motion.base_quat, truth.base_quat, atol=1e-9)
    # Differences: right where the motion is smooth, smeared where it is not.
    off = np.abs(motion.qvel - truth.qvel).max(axis=1)
    assert np.median(off) < 0.15
    assert np.quantile(np.abs(motion.angular_velocity - truth.angular_velocity), 0.5) < 0.02
    assert (motion.contact == truth.contact).mean() > 0.96
    np.testing.assert_allclose(motion.com, truth.com, atol=1e-3)


def test_the_rate_is_the_users_where_nothing_stands_beside(copied):
    beside(copied).unlink()
    assert llsrbm.load_motion(copied, fps=25).fps == 25
    with pytest.raises(FileFormatError, match="does not say its rate; expected frames per second"):
        llsrbm.load_motion(copied)
    with pytest.raises(FileFormatError, match="0 < fps"):
        llsrbm.load_motion(copied, fps=0)


def test_a_rate_that_contradicts_the_file_is_remarked_on(copied):
    assert llsrbm.load_motion(copied, fps=30).fps == 30
    other = llsrbm.load_motion(copied, fps=50)
    assert other.fps == 30
    assert other.remarks[0] == "it says 30 frames/s: the 50 asked for do not count"


def test_joints_in_another_order(copied):
    told = json.loads(beside(copied).read_text())
    rows = np.loadtxt(copied, delimiter=",")
    right = llsrbm.load_motion(copied)
    np.savetxt(copied, np.hstack([rows[:, :7], rows[:, :6:-1]]), delimiter=",")
    beside(copied).write_text(json.dumps(told | {"joint_order": told["joint_order"][::-1]}))
    turned = llsrbm.load_motion(copied)
    np.testing.assert_allclose(turned.joint_position, right.joint_position, atol=1e-12)


@pytest.mark.parametrize(
    ("told", "message"),
    [
        ("{", "not a JSON file: Expecting"),
        ("[1]", "expected a JSON object"),
        ('{"fps": "30"}', "0 < fps"),
        ('{"fps": NaN}', "expected finite numbers, got NaN"),
        ('{"fps": 30, "joint_order": ["a\\nb"]}', "expected the robot that moves"),
        ('{"fps": 30, "quaternion_order": "wxyz"}', 'expected "xyzw", got "wxyz"'),
        ('{"fps": 30, "columns": ["x", "y", "z", "qw"]}', 'columns: expected "qx", got "qw"'),
        ('{"fps": 30, "columns": 3}', r'columns: expected \["x", "y"'),
        ('{"fps": 30, "column_units": ["cm", "cm", "cm"]}', 'column_units: expected "m", got "cm"'),
        (
            json.dumps({"fps": 30, "column_units": [*"mmm1111", *["deg"] * 12]}),
            'column_units: expected "rad", got "deg"; such tables are not converted',
        ),
        ("[" * 100000, "nested too deeply"),
    ],
)
def test_nonsense_beside(copied, told, message):
    beside(copied).write_text(told)
    with pytest.raises(FileFormatError, match=message) as caught:
        llsrbm.load_motion(copied)
    assert "\n" not in str(caught.value)


GOOD = ["0,0,0.5,0,0,0,1" + ",0" * 12] * 4


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (["Frame,root_translateX,root_rotateX", *GOOD], "begins with a header.*ProtoMotions"),
        (
            [GOOD[0] + ",0", *GOOD],
            r"row 1 has 20 columns; expected 19: 7 of .* anymal, 12 \(.*a column of the time",
        ),
        ([GOOD[0][2:], *GOOD], "row 1 has 18 columns; .*; Euler angles .* are not read"),
        ([row.replace(",", " ") for row in GOOD], "row 1 has spaces between its numbers; .*commas"),
        ([row.replace(",", ";") for row in GOOD], "row 1 has semicolons between its numbers"),
        ([GOOD[0], *(row + "," for row in GOOD)], "row 2 ends with a comma; expected rows of"),
        ([GOOD[0], "0,0,x", *GOOD], "row 2: not all of it is numbers"),
        ([GOOD[0], GOOD[0].replace("0.5", "0_5"), *GOOD], "row 2: not all of it is numbers"),
        ([GOOD[0], GOOD[0].replace("0.5", "٥"), *GOOD], "row 2: not all of it is numbers"),
        ([GOOD[0], GOOD[0].replace("0.5", "nan")], "expected finite numbers"),
        ([GOOD[0], GOOD[0].replace("0.5", "1e200")], "expected finite numbers up to 10000"),
        ([GOOD[0], GOOD[0].replace(",1", ",0")], "norm 0 in frame 1"),
        (GOOD[:1], "2 to 50000 frames, got 1"),
        (GOOD[:1] * 50001, "50001 rows; at most 50000"),
    ],
)
def test_no_such_table(tmp_path, lines, message):
    path = tmp_path / "x.csv"
    path.write_text("\n".join(lines))
    with pytest.raises(FileFormatError, match=message) as caught:
        llsrbm.load_motion(path, fps=50)
    assert "\n" not in str(caught.value)


def test_no_text_too_large_not_there(tmp_path):
    path = tmp_path / "x.csv"
    path.write_bytes(b"\xff\xfe\x80")
    with pytest.raises(FileFormatError, match="not a text file"):
        llsrbm.load_motion(path, fps=50)
    with path.open("wb") as large:
        large.truncate(40 * 1024**2)
    with pytest.raises(FileFormatError, match="too large for rows of numbers"):
        llsrbm.load_motion(path, fps=50)
    for other in (tmp_path / "none.csv", tmp_path):
        with pytest.raises(FileFormatError, match="cannot be read"):
            llsrbm.load_motion(other, format="unitree-csv", fps=50)
