"""Drives in first robot files: those that URDF and SRDF have, and those that are assumed."""

import re
import tomllib

import numpy as np
import pytest

from llsrbm.cli import main
from llsrbm.installed import assets_directory
from llsrbm.robots.drives.stated import known_drives
from tests.llsrbm.robots.draft.first_files import first_file, written

LEGS = ("left", "right")


def line(robot, key):
    """The first line of its file with that key, after [drives]."""
    text = robot.path.read_text().partition("[drives]")[2]
    return next(line for line in text.splitlines() if line.startswith(f"{key} ="))


def test_go1s_friction_is_its_urdfs_and_its_rotors_are_named():
    robot = first_file("go1").robot
    assert robot.friction == pytest.approx(0.2)
    assert robot.damping == pytest.approx(0.01)
    # 2e-4 kg m2 a Nm: without the gears, which are 6 and 9, the rotors say nothing.
    assert robot.armature == pytest.approx(2e-4 * robot.torque_limit, rel=1e-3)
    assert "0.0001118, 0.0001118, 0.0001118 kg m2" in line(robot, "armature")
    assert "assumed" in line(robot, "armature")
    said = "drives: friction, damping published; rotors, delay assumed"
    assert said in first_file("go1").said


def test_taloss_rotors_are_its_srdfs():
    robot = first_file("talos").robot
    np.testing.assert_allclose(robot.armature, 1e-5 * 100**2)
    assert "talos.srdf" in line(robot, "armature")
    # The URDF has friction of arms alone.
    np.testing.assert_allclose(robot.friction[robot.arm_joint_index], 1.0)
    np.testing.assert_allclose(
        robot.friction[robot.leg_joint_index], 0.01 * robot.torque_limit[robot.leg_joint_index]
    )
    known = known_drives(robot.file)
    assert known["armature"] == known["arms.armature"] == "published"
    assert known["friction"] == "assumed"


def test_what_nobody_states_is_written_and_said_to_be_assumed():
    robot = first_file("solo12").robot
    drives = tomllib.loads(robot.path.read_text())["drives"]
    assert drives.keys() == {"armature", "friction", "damping", "delay"}
    for key in drives:
        assert "assumed" in line(robot, key)
    assert set(known_drives(robot.file).values()) == {"assumed"}


def rotors(parameters):
    return f"<robot name='b'><rotor_params>{parameters}</rotor_params></robot>"


@pytest.fixture
def biped(tmp_path):
    """SLIDER's URDF in a package's folders, friction at one joint, more at its like."""
    urdf = tmp_path / "robots" / "biped.urdf"
    urdf.parent.mkdir()
    (tmp_path / "srdf").mkdir()
    text = (assets_directory() / "slider" / "slider.urdf").read_text()
    for leg, friction in zip(LEGS, (0.3, 0.4), strict=True):
        joint = f'<joint name="{leg}_roll"'
        assert joint in text
        head, _, rest = text.partition(joint)
        end = rest.index("</joint>")
        text = f'{head}{joint}{rest[:end]}<dynamics friction="{friction}"/>{rest[end:]}'
    urdf.write_text(text)
    return urdf


def test_joints_without_a_number_are_named_and_legs_that_differ(biped, tmp_path):
    robot = written(tmp_path / "biped.toml", str(biped)).robot
    k = robot.joint_names.index("left_roll")
    assert robot.friction[k] == 0.3
    assert (robot.friction != 0.3).sum() == len(robot.joint_names) - len(LEGS)
    said = line(robot, "friction")
    assert "<dynamics>; assumed of left_" in said
    assert "as of leg left, it has 0.4 for right_roll" in said
    assert known_drives(robot.file)["friction"] == "assumed"


def test_an_srdf_of_other_joints_says_nothing(biped, tmp_path):
    srdf = tmp_path / "srdf" / "other.srdf"
    srdf.write_text(rotors('<joint name="tail" mass="1e-5" gear_ratio="100"/>'))
    robot = written(tmp_path / "b.toml", str(biped)).robot
    assert "assumed: 0.0002 kg m2" in line(robot, "armature")


def actuated(urdf, joint, inertia, gear):
    """The URDF with a transmission of a joint in Drake's words."""
    text = urdf.read_text().replace("<robot ", '<robot xmlns:drake="http://drake.mit.edu" ', 1)
    rotor = f'<drake:rotor_inertia value="{inertia}"/>'
    gears = (
        f'<drake:gear_ratio value="{gear}"/>'
        if gear
        else "<mechanicalReduction>7</mechanicalReduction>"
    )
    actuator = f'<actuator name="a">{rotor}{gears}</actuator>'
    more = f'<transmission name="t"><joint name="{joint}"/>{actuator}</transmission></robot>'
    urdf.write_text(text.replace("</robot>", more))


@pytest.mark.parametrize(("gear", "felt"), [("20", 0.04), ("", 1e-4)])
def test_transmissions_have_rotors_in_drakes_words(biped, tmp_path, gear, felt):
    actuated(biped, "left_roll", "1e-4", gear)
    robot = written(tmp_path / "biped.toml", str(biped)).robot
    k = robot.joint_names.index("left_roll")
    assert robot.armature[k] == pytest.approx(felt)
    said = line(robot, "armature")
    assert "the URDF's transmissions: rotors times their gears squared" in said
    assert "assumed of left_" in said


@pytest.mark.parametrize(("inertia", "said"), [("nan", "nan"), ("-1e-4", "-0.0001")])
def test_a_transmissions_rotor_that_is_none_is_refused(biped, tmp_path, inertia, said, capsys):
    actuated(biped, "left_roll", inertia, "20")
    assert main(["robot", "new", str(biped), "--out", str(tmp_path / "biped.toml")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert 'transmission of "left_roll": rotor_inertia' in error
    assert said in error


def test_stops_in_degrees_are_told(biped, tmp_path):
    told = "the URDF has stops of left_roll at -90 and 90 rad: are they degrees?"
    assert told not in written(tmp_path / "a.toml", str(biped)).robot.path.read_text()
    head, _, rest = biped.read_text().partition('<joint name="left_roll"')
    limit = re.search(r'lower="[^"]*" upper="[^"]*"', rest)
    rest = rest.replace(limit.group(), 'lower="-90" upper="90"', 1)
    biped.write_text(f'{head}<joint name="left_roll"{rest}')
    assert told in written(tmp_path / "b.toml", str(biped)).robot.path.read_text()


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ('<joint name="left_roll" mass="nan" gear_ratio="9"/>', '<joint mass="nan">'),
        ('<joint name="left_roll" mass="1e-5"/>', "<joint> has no gear_ratio"),
        ('<joint name="left_roll" mass="1e-5" gear_ratio="9"/>' * 2, "it is there twice"),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_rotors_that_are_none_are_refused_by_joint_and_value(
    biped, tmp_path, parameters, said, encoding, capsys
):
    (tmp_path / "srdf" / "biped.srdf").write_text(rotors(parameters), encoding)
    (tmp_path / "srdf" / "another.srdf").mkdir()
    assert main(["robot", "new", str(biped), "--out", str(tmp_path / "biped.toml")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert 'biped.srdf: rotor_params: joint "left_roll": ' in error
    assert said in error


def test_friction_that_would_stop_the_drives_is_not_meant(biped, tmp_path):
    text = biped.read_text().replace('friction="0.3"', 'friction="3e4" damping="2e4"')
    biped.write_text(text)
    robot = written(tmp_path / "biped.toml", str(biped)).robot
    assert (robot.friction < 0.1 * robot.torque_limit).all()
    assert (robot.damping * robot.speed_limit < 0.1 * robot.torque_limit).all()
    for key, number in (("friction", "30000"), ("damping", "20000")):
        assert f"{number} for left_roll, which takes all" in line(robot, key)
