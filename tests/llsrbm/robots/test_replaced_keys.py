"""A robot file that still has a key of an older version is told what replaced it."""

import pytest

from llsrbm.errors import RobotFileError
from llsrbm.robots.assets import robot_files
from llsrbm.robots.schema import REPLACED, read_robot_file

ANYMAL = robot_files()["anymal"].read_text()


@pytest.mark.parametrize(
    ("line", "instead"),
    [
        ("contact_force = 230.0", "limits.torque_share"),
        ("foot_speed_in_base = [2.0, 2.0, 3.5]", "limits.joint_speed"),
    ],
)
def test_it_says_what_replaced_the_key(tmp_path, line, instead):
    path = tmp_path / "old.toml"
    path.write_text(ANYMAL.replace("[limits]\n", f"[limits]\n{line}\n"))
    with pytest.raises(RobotFileError) as caught:
        read_robot_file(path)
    said = str(caught.value)
    key = line.split(" ")[0]
    assert said.startswith(f'{path}: "limits.{key}" is no key any more; remove it: ')
    assert instead in said
    assert "\n" not in said


def test_replaced_keys_are_no_keys(tmp_path):
    path = tmp_path / "new.toml"
    path.write_text(ANYMAL)
    limits = read_robot_file(path).limits.model_dump()
    assert not {key.removeprefix("limits.") for key in REPLACED} & set(limits)
