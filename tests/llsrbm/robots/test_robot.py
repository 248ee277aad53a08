"""What is computed from the URDF, against Pinocchio and against a robot made by hand."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.errors import InputError, RobotFileError
from llsrbm.robots import load_robot, names
from llsrbm.robots.schema import robot_files
from tests.llsrbm.robots.mistakes import check_one_clear_line

ANYMAL = robot_files()["anymal"].read_text()
QUADRUPEDS = {"anymal": -1, "solo12": -1, "go2": 1}


@pytest.fixture(params=QUADRUPEDS)
def robot(request):
    return load_robot(request.param)


def test_anymal_has_the_known_figures():
    anymal = load_robot("anymal")
    assert anymal.mass == pytest.approx(30.475, abs=1e-3)
    assert np.diag(anymal.inertia) == pytest.approx([1.004, 2.078, 2.082], abs=1e-3)
    assert anymal.com == pytest.approx([0, 0, 0.458 + 0.009], abs=1e-3)  # the balls' share
    assert anymal.chains.mass == pytest.approx([3.408] * 4, abs=1e-3)
    assert [leg.name for leg in anymal.legs] == ["LF", "RF", "LH", "RH"]
    assert anymal.legs[0].joints == ("LF_HAA", "LF_HFE", "LF_KFE")
    assert anymal.hips[0] == pytest.approx([0.277 + 0.0635, 0.116 + 0.041, 0.0])


def test_a_changed_file_is_read_again(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(ANYMAL)
    first = load_robot(str(path))
    assert load_robot(str(path)) is first
    path.write_text(ANYMAL + "\n[control]\nrate = 500.0\n")
    changed = load_robot(str(path))
    assert changed.file.control.rate == 500.0
    assert load_robot(str(path)) is changed
    assert first.file.control.rate == 400.0  # a robot loaded earlier does not change
    path.write_text("nonsense")
    with pytest.raises(RobotFileError, match=r"mine\.toml"):
        load_robot(str(path))
    path.unlink()
    with pytest.raises(RobotFileError, match="cannot be read"):
        load_robot(str(path))


def test_a_changed_urdf_is_read_again(tmp_path):
    slider = robot_files()["slider"]
    description = slider.parent / "../slider/slider.urdf"
    (tmp_path / "robot.urdf").write_text(description.read_text())
    path = tmp_path / "mine.toml"
    path.write_text(slider.read_text().replace("../slider/slider.urdf", "robot.urdf"))
    first = load_robot(str(path))
    heavier = description.read_text().replace('<mass value="', '<mass value="1', 1)
    (tmp_path / "robot.urdf").write_text(heavier)
    assert load_robot(str(path)).mass > first.mass + 1


def test_the_default_posture_stands_on_the_ground_below_its_com(robot):
    data = robot.model.createData()
    com = pin.centerOfMass(robot.model, data, robot.posture)
    pin.updateFramePlacements(robot.model, data)
    feet = np.array([data.oMf[leg.foot_frame_id].translation for leg in robot.legs])
    assert com == pytest.approx(robot.com, abs=1e-12)
    assert com[:2] == pytest.approx([0, 0], abs=1e-12)
    lowest = feet - [0, 0, robot.foot_lift]
    assert lowest == pytest.approx(robot.feet, abs=1e-12)
    assert lowest[:, 2].min() == pytest.approx(0, abs=1e-12)
    assert lowest[:, 2].max() < 0.01
    assert robot.posture[3:7].tolist() == [0, 0, 0, 1]
    assert robot.posture[:3] == pytest.approx(robot.base_position)
    for leg in robot.legs:
        assert robot.posture[leg.q_index] == pytest.approx(robot.file.posture[leg.name])


def test_kept_stops_leave_room_but_for_the_posture_in_which_it_stands(robot):
    (lower, upper), (kept, kept_above) = robot.joint_stops, robot.kept_stops
    stands, margin = robot.posture[7:], 0.01 * (upper - lower)
    assert ((kept <= stands) & (stands <= kept_above)).all()
    away = (stands > lower + margin) & (stands < upper - margin)
    assert away.sum() > len(stands) / 2
    np.testing.assert_allclose(kept[away], (lower + margin)[away])
    np.testing.assert_allclose(kept_above[away], (upper - margin)[away])


def test_mass_and_inertia_are_those_of_all_bodies(robot):
    """Summed body by body with the parallel-axis theorem, not by Pinocchio's composite."""
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.posture)
    mass, inertia = 0.0, np.zeros((3, 3))
    for joint in range(1, robot.model.njoints):
        body, pose = robot.model.inertias[joint], data.oMi[joint]
        d = pose.act(body.lever) - robot.com
        inertia += pose.rotation @ body.inertia @ pose.rotation.T
        inertia += body.mass * (d @ d * np.eye(3) - np.outer(d, d))
        mass += body.mass
    assert mass == pytest.approx(robot.mass)
    assert inertia == pytest.approx(robot.inertia, abs=1e-12)


@pytest.mark.parametrize(("name", "hind"), QUADRUPEDS.items())
def test_hind_legs_are_mirrored_only_if_they_bend_the_other_way(name, hind):
    robot = load_robot(name)
    assert robot.mirrors.tolist() == [[1, 1, 1], [1, -1, 1], [hind, 1, 1], [hind, -1, 1]]


def test_names_are_listed_and_an_unknown_one_is_refused():
    assert "anymal" in names()
    with pytest.raises(InputError, match=r'no robot "anymall"; did you mean "anymal"\? valid: a1'):
        load_robot("anymall")
    with pytest.raises(RobotFileError, match=r"nosuch\.toml: cannot be read"):
        load_robot("./nosuch.toml")


WRONG_FOR_THE_URDF = {
    "limit of nothing": ("torque = 40.0", "torque = 1e-300", ["limits.torque", "1e-06", "LF_HAA"]),
    "no such frame": (
        'foot = "LF_FOOT"',
        'foot = "LF_FOT"',
        ["legs.LF.foot", '"LF_FOOT"', "valid"],
    ),
    "foot on the base": (
        'foot = "LF_FOOT"',
        'foot = "imu_link"',
        ["legs.LF.foot", "no joint moves"],
    ),
    "hip of another leg": (
        'hip = "LF_HFE"',
        'hip = "RF_HFE"',
        ["legs.LF.hip", '"RF_HFE"', "LF_HAA, LF_HFE, LF_KFE"],
    ),
    "a limit for some joints only": (
        "torque = 40.0",
        "torque = [40.0, 40.0]",
        ["limits.torque", "one number, or 3", "(LF_HAA, LF_HFE, LF_KFE)", "got 2"],
    ),
    "no such package": ("example-robot-data", "example-robot-dat", ["urdf.package", "pip install"]),
    "the same leg twice": (
        'foot = "RF_FOOT", hip = "RF_HFE"',
        'foot = "LF_FOOT", hip = "LF_HFE"',
        ["legs.RF", "also belongs to leg LF"],
    ),
}


@pytest.mark.parametrize("mistake", WRONG_FOR_THE_URDF)
def test_what_contradicts_the_urdf_is_one_clear_line(tmp_path, mistake):
    right, wrong, expected = WRONG_FOR_THE_URDF[mistake]
    assert right in ANYMAL
    check_one_clear_line(tmp_path / "mine.toml", ANYMAL.replace(right, wrong, 1), expected)


def test_a_joint_in_no_leg_is_refused(tmp_path):
    lines = [line for line in ANYMAL.splitlines() if not line.startswith("RH =")]
    path = tmp_path / "three.toml"
    path.write_text("\n".join(lines))
    with pytest.raises(RobotFileError, match=r"RH_HAA, RH_HFE, RH_KFE .* belong to no leg"):
        load_robot(str(path))


def beside(tmp_path: Path, urdf: str) -> Path:
    """ANYmal's file with a URDF of that text beside it."""
    (tmp_path / "robot.urdf").write_text(urdf)
    path = tmp_path / "mine.toml"
    source = (
        'package = "example-robot-data"\npath = "anymal_b_simple_description/robots/anymal.urdf"'
    )
    path.write_text(ANYMAL.replace(source, 'file = "robot.urdf"'))
    return path


@pytest.mark.parametrize(
    "text",
    ["", "not XML", "<robot name='x'><link/></robot>", "<robot name='x'><link name='a'/></robot>"],
)
def test_a_urdf_that_is_none(tmp_path, text):
    path = beside(tmp_path, text)
    with pytest.raises(
        RobotFileError, match=r"mine\.toml: urdf: .*robot\.urdf( is not (a|the) URDF|: <link> has)"
    ):
        load_robot(str(path))


def test_a_urdf_that_is_missing(tmp_path):
    path = beside(tmp_path, "")
    (tmp_path / "robot.urdf").unlink()
    with pytest.raises(RobotFileError, match=r"urdf\.file: no such file: .*robot\.urdf"):
        load_robot(str(path))


def test_limits_that_the_file_leaves_out_are_the_urdfs(tmp_path):
    """The second leg's knee has others than the rest."""
    urdf = load_robot("anymal").urdf_path.read_text()
    before, after = urdf.split('<joint name="RF_KFE"')
    after = after.replace('effort="80"', 'effort="66"', 1).replace('"15.0"', '"11.0"', 1)
    path = beside(tmp_path, f'{before}<joint name="RF_KFE"{after}')
    lines = path.read_text().splitlines()
    kept = [line for line in lines if not line.startswith(("torque = ", "joint_speed = "))]
    assert len(kept) == len(lines) - 2
    path.write_text("\n".join(kept))
    robot = load_robot(str(path))
    torque, speed = np.full(12, 80.0), np.full(12, 15.0)
    knee = robot.joint_names.index("RF_KFE")
    torque[knee], speed[knee] = 66.0, 11.0
    np.testing.assert_array_equal(robot.torque_limit, torque)
    np.testing.assert_array_equal(robot.speed_limit, speed)
    assert load_robot("anymal").torque_limit.tolist() == [40.0] * 12  # the file's, not the URDF's
