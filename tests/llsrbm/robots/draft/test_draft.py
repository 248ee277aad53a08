"""First robot files from URDFs that this project did not tune, held against what they describe."""

from __future__ import annotations

import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest

from llsrbm.cli import main
from llsrbm.errors import RobotFileError
from llsrbm.robots import draft, load_robot
from llsrbm.robots.assets import assets_directory, package_share

PACKAGE = "example-robot-data"
QUADRUPEDS = {
    "a1": "a1_description/urdf/a1.urdf",
    "b1": "b1_description/urdf/b1.urdf",
    "go1": "go1_description/urdf/go1.urdf",
    "laikago": "laikago_description/urdf/laikago.urdf",
    "hyq": "hyq_description/robots/hyq_no_sensors.urdf",
    "anymal_c": "anymal_c_simple_description/urdf/anymal.urdf",
    "solo12": "solo_description/robots/solo12.urdf",
}
G1 = "g1_description/urdf/g1_29dof_rev_1_0.urdf"


def written(path, *arguments):
    """The robot of a file that the command writes."""
    assert main(["robot", "new", *arguments, "--out", str(path)]) == 0
    return load_robot(str(path))


@pytest.fixture(scope="module", params=QUADRUPEDS)
def quadruped(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("draft") / f"{request.param}.toml"
    return written(path, f"{PACKAGE}:{QUADRUPEDS[request.param]}", "--name", request.param)


def test_legs_are_found_and_named_by_where_they_are(quadruped):
    assert [leg.name for leg in quadruped.legs] == ["FL", "FR", "RL", "RR"]
    x, y, _ = quadruped.hips.T
    assert (np.sign(x) == [1, 1, -1, -1]).all()
    assert (np.sign(y) == [1, -1, 1, -1]).all()
    assert len(quadruped.joint_names) == 12


def test_it_stands_on_bent_legs_within_its_joints_limits_and_its_own_reach(quadruped):
    q = quadruped.posture[7:]
    assert (q >= quadruped.model.lowerPositionLimit[7:] - 1e-4).all()
    assert (q <= quadruped.model.upperPositionLimit[7:] + 1e-4).all()
    hip = quadruped.base_position + quadruped.hips
    seen = (quadruped.feet - hip) * quadruped.mirrors
    reach = quadruped.file.reach
    assert (seen > np.array(reach.lower) + 0.01).all()
    assert (seen < np.array(reach.upper) - 0.01).all()
    distance = np.linalg.norm(seen, axis=1)
    assert ((distance > reach.distance[0]) & (distance < reach.distance[1])).all()
    # All at one height, and the CoM between them.
    assert np.ptp(quadruped.feet[:, 2]) < 1e-3
    assert (quadruped.feet[:, 0].min() + 0.05 < 0 < quadruped.feet[:, 0].max() - 0.05).all()


def test_drives_are_the_urdfs_where_it_has_some_that_are_meant(quadruped):
    urdf = quadruped.model.effortLimit[6:]
    if quadruped.name in ("solo12",):  # whose URDF says 1000 Nm
        assert (quadruped.torque_limit < 10).all()
    else:
        np.testing.assert_allclose(quadruped.torque_limit, urdf, rtol=1e-3)
    assert ((quadruped.speed_limit >= 2) & (quadruped.speed_limit <= 100)).all()


def test_hind_legs_bend_the_straighter_way(tmp_path):
    """ANYmal C's knees point at each other, as in the package's own standing posture."""
    robot = written(tmp_path / "anymal_c.toml", f"{PACKAGE}:{QUADRUPEDS['anymal_c']}")
    knees = robot.posture[7:][robot.leg_joint_index][:, 2]
    assert (np.sign(knees) == [-1, -1, 1, 1]).all()


def test_a_biped_stands_on_its_soles(tmp_path):
    urdf = assets_directory() / "slider" / "slider.urdf"
    drafted = written(tmp_path / "biped.toml", str(urdf))
    tuned = load_robot("slider")
    assert [leg.name for leg in drafted.legs] == [leg.name for leg in tuned.legs]
    assert drafted.file.foot.corners == tuned.file.foot.corners
    assert [leg.foot_frame for leg in drafted.legs] == [leg.foot_frame for leg in tuned.legs]
    assert drafted.file.limits.torque == tuned.file.limits.torque


def test_the_file_says_what_is_guessed(tmp_path):
    path = tmp_path / "a1.toml"
    written(path, f"{PACKAGE}:{QUADRUPEDS['a1']}")
    text = path.read_text()
    assert text.lower().count("guessed:") >= 5
    assert tomllib.loads(text)["urdf"] == {"package": PACKAGE, "path": QUADRUPEDS["a1"]}


def test_arms_are_named_not_guessed_away(tmp_path, capsys):
    assert main(["robot", "new", f"{PACKAGE}:{G1}", "--out", str(tmp_path / "g1.toml")]) == 2
    said = capsys.readouterr().err
    assert "waist_yaw_joint" in said
    assert 'type="fixed"' in said
    assert not list(tmp_path.iterdir())


def test_a_sole_whose_frame_is_not_on_the_ground_is_told(tmp_path):
    source = (assets_directory() / "slider" / "slider.urdf").read_text()
    path = tmp_path / "biped.urdf"
    path.write_text(source.replace('<origin xyz="0 0 -0.045"/>', '<origin xyz="0 0 -0.015"/>'))
    with pytest.raises(RobotFileError, match=r"left_sole is 0\.030 m above .* add a link"):
        draft.read_anatomy(path, (tmp_path,))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["no.urdf"], "no such file; expected a URDF"),
        (["nothing-here:a.urdf"], 'no robot data of a package "nothing-here"'),
        ([f"{PACKAGE}:nothing.urdf"], "no such file; expected a URDF"),
        ([f"{PACKAGE}:{QUADRUPEDS['a1']}", "--name", "A 1"], "expected lower case letters"),
    ],
)
def test_bad_input_is_one_line(arguments, said, tmp_path, capsys):
    assert main(["robot", "new", *arguments, "--out", str(tmp_path / "a.toml")]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_a_file_that_is_there_is_kept(tmp_path, capsys):
    path = tmp_path / "a1.toml"
    path.write_text("mine")
    command = ["robot", "new", f"{PACKAGE}:{QUADRUPEDS['a1']}", "--out", str(path)]
    assert main(command) == 2
    assert "expected --force" in capsys.readouterr().err
    assert path.read_text() == "mine"
    assert main([*command, "--force"]) == 0


def test_what_is_no_urdf_is_told(tmp_path):
    path = tmp_path / "broken.urdf"
    path.write_text("<robot>")
    with pytest.raises(RobotFileError, match="not"):
        draft.read_anatomy(path, (tmp_path,))


def test_a_urdf_beside_the_file_is_found_from_there(tmp_path):
    share = package_share(PACKAGE, Path())
    (tmp_path / "urdf").mkdir()
    shutil.copy(share / PACKAGE / "robots" / QUADRUPEDS["solo12"], tmp_path / "urdf" / "my.urdf")
    out = tmp_path / "files" / "my.toml"
    out.parent.mkdir()
    table = draft.urdf_beside(tmp_path / "urdf" / "my.urdf", out)
    assert table == {"file": "../urdf/my.urdf"}
