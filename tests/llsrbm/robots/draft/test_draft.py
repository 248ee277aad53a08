"""First robot files from URDFs that this project did not tune, held against what they describe."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from llsrbm.cli import main
from llsrbm.errors import RobotFileError
from llsrbm.installed import assets_directory
from llsrbm.robots import draft, load_robot
from llsrbm.robots.urdf import package_share
from tests.llsrbm.robots.draft.first_files import PACKAGE, URDFS, first_file, written


@pytest.fixture(params=["a1", "anymal_c", "solo12"])
def quadruped(request):
    return first_file(request.param).robot


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


def test_flights_may_be_short_where_legs_are_slow_to_catch_a_fall(quadruped):
    slow = quadruped.name in ("anymal_c", "solo12")
    assert quadruped.file.timing.flight[0] == (0.2 if slow else 0.3)


def test_a_foot_that_is_a_disc_has_the_discs_radius():
    radius = first_file("solo12").robot.file.foot.radius
    assert radius == pytest.approx(0.016, abs=1e-4)


def test_mirrored_hind_legs_bend_the_other_way(quadruped):
    """Knees of ANYmal C and Solo 12 point at each other, all others backward."""
    knees = np.sign(quadruped.posture[7:][quadruped.leg_joint_index][:, 2])
    mirrored = quadruped.name in ("anymal_c", "solo12")
    assert (knees == ([-1, -1, 1, 1] if mirrored else [-1, -1, -1, -1])).all()


def test_a_biped_stands_on_its_soles(tmp_path):
    urdf = assets_directory() / "slider" / "slider.urdf"
    drafted = written(tmp_path / "biped.toml", str(urdf)).robot
    tuned = load_robot("slider")
    assert [leg.name for leg in drafted.legs] == [leg.name for leg in tuned.legs]
    assert drafted.file.foot.corners == tuned.file.foot.corners
    assert [leg.foot_frame for leg in drafted.legs] == [leg.foot_frame for leg in tuned.legs]
    assert drafted.file.limits.torque == tuned.file.limits.torque


def test_the_file_says_what_is_guessed():
    text = first_file("a1").text
    assert text.lower().count("guessed:") >= 5
    assert tomllib.loads(text)["urdf"] == {"package": PACKAGE, "path": URDFS["a1"]}


def test_a_waist_below_the_root_is_held(tmp_path):
    source = (assets_directory() / "slider" / "slider.urdf").read_text()
    path = tmp_path / "waist.urdf"
    path.write_text(source.replace("</robot>", WAIST + "</robot>"))
    anatomy = draft.read_anatomy(path)
    assert anatomy.held == {"waist": 0.0}
    tuned = load_robot("slider")
    legs = [anatomy.model.names[joint] for leg in anatomy.joint_ids for joint in leg]
    assert tuple(legs) == tuned.joint_names
    assert anatomy.mass == pytest.approx(tuned.mass)


WAIST = """<link name="chest"/><joint name="waist" type="revolute"><parent link="chest"/>
    <child link="pelvis"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"""


def test_joints_that_move_some_of_the_feet_are_refused(tmp_path):
    """A spine, which the hind legs are on."""
    spine = f"""<link name="hind">{INERTIA.format(m=3, i=0.1)}</link>
    <joint name="spine" type="revolute"><parent link="trunk"/><child link="hind"/>
    <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"""
    urdf = tmp_path / "quad.urdf"
    hind = '<parent link="hind"/><child link="h'
    text = _quadruped().replace('<parent link="trunk"/><child link="h', hind)
    urdf.write_text(text.replace("</robot>", spine + "</robot>"))
    with pytest.raises(RobotFileError, match=r"to h._2 reaches as low as the leg to f._2"):
        draft.read_anatomy(urdf)


def test_legs_of_another_number_of_joints_are_named(tmp_path):
    text = _quadruped()
    for leg in ("fl", "fr", "hl", "hr"):
        text = text.replace(f'name="{leg}_0" type="continuous"', f'name="{leg}_0" type="fixed"')
    urdf = tmp_path / "quad.urdf"
    urdf.write_text(text)
    with pytest.raises(RobotFileError, match=r"4 chains .* 2 joints \(fl_1, fl_2\).* 3 joints"):
        draft.read_anatomy(urdf)


@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_a_sole_whose_frame_is_elsewhere_gets_one_on_the_ground(tmp_path, turn):
    """SLIDER's own frame 3 cm higher, and turned."""
    source = (assets_directory() / "slider" / "slider.urdf").read_text()
    path = tmp_path / "biped.urdf"
    moved = f'<origin xyz="0 0 -0.015" rpy="0 {turn} 0"/>'
    path.write_text(source.replace('<origin xyz="0 0 -0.045"/>', moved))
    drafted, tuned = draft.read_anatomy(path), load_robot("slider")
    assert drafted.feet == tuple(drafted.frames) == ("left_sole_middle", "right_sole_middle")
    assert drafted.corners == tuned.file.foot.corners
    for chains in zip(drafted.chains.foot_ids, tuned.chains.foot_ids, strict=True):
        models = (drafted.chains.model, tuned.chains.model)
        one, other = (m.frames[i].placement for m, i in zip(models, chains, strict=True))
        np.testing.assert_allclose(one.translation, other.translation, atol=1e-4)
        np.testing.assert_allclose(one.rotation, other.rotation, atol=1e-6)


def test_a_sole_that_slants_at_zero_is_level_where_it_stands(tmp_path):
    """SLIDER's feet turned in their ankles, with frames at their soles as the URDF has it."""
    source = (assets_directory() / "slider" / "slider.urdf").read_text()
    for leg in ("left", "right"):
        joint = f'<parent link="{leg}_cross"/><child link="{leg}_foot"/>\n    <origin xyz="0 0 0"'
        assert joint in source
        source = source.replace(joint, f'{joint} rpy="0 0.15 0"')
    path = tmp_path / "biped.urdf"
    path.write_text(source)
    robot = written(tmp_path / "biped.toml", str(path)).robot
    assert [leg.foot_frame for leg in robot.legs] == ["left_sole", "right_sole"]
    assert robot.file.foot.corners == load_robot("slider").file.foot.corners
    ankle = robot.posture[7 + robot.joint_names.index("left_ankle_pitch")]
    hip = robot.posture[7 + robot.joint_names.index("left_pitch")]
    assert hip + ankle == pytest.approx(-0.15, abs=0.01)


ROMEO = "romeo_description/urdf/romeo.urdf"


def _romeo(tmp_path, ankle):
    """Its ankles' lower stop at that angle, rad."""
    share = package_share(PACKAGE, Path("draft"))
    text = (share / PACKAGE / "robots" / ROMEO).read_text()
    stop = 'effort="25.76" lower="-0.523599"'
    assert text.count(stop) == 2
    path = tmp_path / "romeo.urdf"
    path.write_text(text.replace(stop, f'effort="25.76" lower="{ankle}"'))
    return path


@pytest.mark.nightly
def test_legs_stand_straighter_where_an_ankle_stops(tmp_path):
    """Knees that bend by twice as much: at 0.74 of its length the ankle needs 0.8 rad."""
    proposal = draft.propose(draft.read_anatomy(_romeo(tmp_path, -0.65)))
    ankle = proposal.values["posture.left"][4]
    assert -0.65 <= ankle < -0.5
    proposal = draft.propose(draft.read_anatomy(_romeo(tmp_path, -1.0)))
    assert proposal.values["posture.left"][4] < -0.7


def test_the_joint_that_lets_no_leg_stand_is_named(tmp_path):
    with pytest.raises(RobotFileError, match=r"and its sole level; .* LAnklePitch at -0.524 rad"):
        draft.propose(draft.read_anatomy(_romeo(tmp_path, -0.523599)))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["no.urdf"], "no such file; expected a URDF"),
        (["nothing-here:a.urdf"], 'no robot data of a package "nothing-here"'),
        ([f"{PACKAGE}:nothing.urdf"], "no such file; expected a URDF"),
        ([f"{PACKAGE}:{URDFS['a1']}", "--name", "A 1"], "expected lower case letters"),
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
    command = ["robot", "new", f"{PACKAGE}:{URDFS['a1']}", "--out", str(path)]
    assert main(command) == 2
    assert "expected --force" in capsys.readouterr().err
    assert path.read_text() == "mine"
    assert main([*command, "--force"]) == 0


QUAD_LEG = """
  <link name="{n}_hip">{inertia}</link><link name="{n}_thigh">{inertia}</link>
  <link name="{n}_calf">{inertia}<collision><origin xyz="0 0 -0.1"/>
    <geometry><capsule radius="0.012" length="0.2"/></geometry></collision></link>
  <joint name="{n}_0" type="continuous"><parent link="trunk"/><child link="{n}_hip"/>
    <origin xyz="{x} {y} 0"/><axis xyz="1 0 0"/><limit effort="{effort}" velocity="20"/></joint>
  <joint name="{n}_1" type="continuous"><parent link="{n}_hip"/><child link="{n}_thigh"/>
    <origin xyz="0 {out} 0"/><axis xyz="0 1 0"/><limit effort="{effort}" velocity="20"/></joint>
  <joint name="{n}_2" type="continuous"><parent link="{n}_thigh"/><child link="{n}_calf"/>
    <origin xyz="0 0 -0.2"/><axis xyz="0 1 0"/><limit effort="{effort}" velocity="20"/></joint>"""
INERTIA = """<inertial><origin xyz="0 0 -0.05"/><mass value="{m}"/>
    <inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial>"""


def _quadruped(effort=17):
    """A URDF of 0.4 m of leg, whose feet are the ends of shanks; one leg has no drives."""
    legs = "".join(
        QUAD_LEG.format(
            n=f"{end}{side}",
            x=0.2 * x,
            y=0.05 * y,
            out=0.06 * y,
            effort=0 if (end, side) == ("h", "r") else effort,
            inertia=INERTIA.format(m=0.3, i=0.001),
        )
        for end, x in (("f", 1), ("h", -1))
        for side, y in (("l", 1), ("r", -1))
    )
    trunk = f"""<link name="trunk">{INERTIA.format(m=7, i=0.1)}<collision>
    <geometry><box size="0.4 0.2 0.1"/></geometry></collision></link>"""
    return f'<robot name="quad">{trunk}{legs}</robot>'


@pytest.mark.parametrize(("effort", "meant"), [(70, True), (110, False)])
def test_torques_that_no_drive_has_are_guessed(tmp_path, effort, meant):
    """Of 42 Nm, weight times leg: a URDF of Spot has 2.8 times as much, drives at most 0.9."""
    urdf = tmp_path / "quad.urdf"
    urdf.write_text(_quadruped(effort))
    proposal = draft.propose(draft.read_anatomy(urdf))
    assert ("limits.torque" not in proposal.guessed) == meant
    assert (proposal.values["limits.torque"] == [effort] * 3) == meant


def test_continuous_joints_and_feet_merged_into_shanks_make_a_robot(tmp_path):
    """Its drives are said to differ in one leg."""
    urdf = tmp_path / "quad.urdf"
    urdf.write_text(_quadruped())
    found = written(tmp_path / "quad.toml", str(urdf))
    robot = found.robot
    assert [leg.foot_frame for leg in robot.legs] == ["FL_foot", "FR_foot", "RL_foot", "RR_foot"]
    np.testing.assert_allclose(robot.joint_stops, np.outer([-np.pi, np.pi], np.ones(12)))
    # Of 0.4 m of leg, however far hips that turn all the way round take it from where they rest.
    assert robot.file.reach.distance[1] < 0.4
    frame = robot.file.urdf.frames["FL_foot"]
    assert frame.link == "fl_calf"
    assert frame.xyz == pytest.approx((0, 0, -0.2), abs=0.01)
    said = "torque as of leg FL, the URDF has 0 for hr_0, 0 for hr_1, 0 for hr_2"
    assert said in found.said
    assert said in found.text
