"""URDFs with numbers that no robot has, or elements where none reads them, are refused by name."""

import pytest

from llsrbm.errors import RobotFileError
from llsrbm.robots import build_robot
from tests.llsrbm.robots.strange_urdf import URDF, added, after, replaced, robot_file

REFUSED = {
    **{
        f"an absurd {key} of {number}": (
            replaced(f'{key}="{old}"', f'{key}="{number}"'),
            [of, number, "expected", "1e+06" if key in ("value", "izz", "rpy") else "100"],
        )
        for of, key, old, number in (
            ("trunk", "value", "5", "1e300"),
            ("trunk", "izz", "0.08", "1e12"),
            ("left_knee", "xyz", "0 0 -0.2", "0 0 -200"),
            ("left_hip", "rpy", "0.02 0 0", "1e300 0 0"),
            ("trunk", "size", "0.2 0.3 0.2", "200 300 200"),
        )
    },
    "an axis without end": (
        replaced('<axis xyz="0 1 0"/>', '<axis xyz="0 1e300 0"/>'),
        ["left_hip", "1e300", "1e+06"],
    ),
    "a radius of nothing": (replaced('radius="0.02"/>', 'radius="1e-300"/>'), ["left_foot", "m"]),
    "a scale of nothing": (
        replaced('<sphere radius="0.02"/>', '<mesh filename="a.stl" scale="1 1e-300 1"/>'),
        ['link "left_foot"', "1e-300", "not zero"],
    ),
    "stops without end": (
        replaced('lower="-2.5" upper="2.5"', 'lower="-1e16" upper="1e16"'),
        ["left_knee", "1e+16", 'type="continuous"'],
    ),
    **{
        f"{key} of {number}": (
            replaced(old, f'{key}="{number}"'),
            ["left_hip", f'{key}="{number}"', limit],
        )
        for key, old, limit in (
            ("effort", 'effort="20"', "limits.torque"),
            ("velocity", 'velocity="10"', "limits.joint_speed"),
        )
        for number in ("1e+308", "1e-300")
    },
    **{
        f"{tag} in {inside}": (
            after(f'<{inside} name="{name}"', f"<{tag}/>"),
            [name, f"<{tag}>", f"in <{inside}>"],
        )
        for tag, inside, name in (
            ("inertial", "joint", "left_hip"),
            ("mass", "link", "trunk"),
            ("joint", "link", "trunk"),
            ("visual", "joint", "left_hip"),
        )
    },
    "a robot in a robot": (added('<robot><link name="a"/></robot>'), ["<robot>", "in <robot>"]),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_no_robot_has_is_one_line_about_the_link_or_joint(tmp_path, case):
    urdf, expected = REFUSED[case]
    with pytest.raises(RobotFileError) as caught:
        build_robot(robot_file(tmp_path, urdf))
    message = str(caught.value)
    assert message.isprintable()
    for part in ["strange.toml: urdf", "strange.urdf", *expected]:
        assert part in message, message


def test_a_posture_beyond_the_stops_is_refused(tmp_path):
    urdf = replaced('lower="-2.5" upper="2.5"', 'lower="0.1" upper="2.5"')
    with pytest.raises(RobotFileError) as caught:
        build_robot(robot_file(tmp_path, urdf))
    for part in ("posture.left", "0.1 to 2.5 rad for left_knee", "-0.8"):
        assert part in str(caught.value)


@pytest.mark.parametrize("code", ["&#10;", "&#x85;", "&#x202e;"])
def test_names_with_control_codes_are_refused(tmp_path, code):
    with pytest.raises(RobotFileError, match=r'<joint name="\?hip"> has control codes') as caught:
        build_robot(robot_file(tmp_path, URDF.replace('"left_hip"', f'"{code}hip"')))
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    "source",
    ['file = "{long}"', 'package = "example-robot-data"\npath = "{long}"'],
    ids=["file", "path"],
)
def test_a_urdf_whose_name_has_no_end_is_missing(tmp_path, source):
    path = robot_file(tmp_path)
    text = path.read_text().replace('file = "strange.urdf"', source.format(long="x" * 5000))
    path.write_text(text)
    with pytest.raises(RobotFileError, match=r"urdf\.(file|path): .*xxx\.\.\."):
        build_robot(path)
