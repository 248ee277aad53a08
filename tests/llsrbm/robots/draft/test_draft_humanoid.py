"""First robot files of humanoids: soles, arms, and what is held."""

import tomllib
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.installed import assets_directory
from llsrbm.robots import draft, load_robot
from llsrbm.robots.feet import foot_contacts
from llsrbm.robots.link_shapes import LinkShapes
from llsrbm.robots.urdf import package_share
from tests.llsrbm.robots.draft.first_files import PACKAGE, URDFS, first_file, written


@pytest.fixture
def humanoid():
    return first_file("g1").robot


def test_a_humanoids_soles_are_found(humanoid):
    text = humanoid.path.read_text()
    frames = tomllib.loads(text)["urdf"]["frames"]
    assert frames["left_sole"] == {"link": "left_ankle_roll_link", "xyz": [0.035, 0.0, -0.035]}
    for table in ("[urdf.held]", "[urdf.frames]", "[arms]", "[posture]", "[arm_reach]"):
        assert "Guessed:" in text.partition(table)[0].splitlines()[-1], table
    assert [leg.name for leg in humanoid.legs] == ["left", "right"]
    assert humanoid.joint_names[:3] == (
        "left_hip_pitch_joint", "left_hip_roll_joint", "left_hip_yaw_joint"
    )  # fmt: skip
    # On the URDF's own spheres, which lie 5 mm above the soles.
    assert humanoid.file.foot.corners[0] == (0.085, 0.03)
    assert foot_contacts(humanoid)[1].centres[0] == pytest.approx([0.085, 0.03, 0.005])
    assert humanoid.com[2] > 0.5


def test_a_humanoids_arms_are_found_up_to_the_elbow(humanoid):
    """As the tuned file has them: wrists and waist held."""
    tuned = load_robot("g1")
    assert [arm.joints for arm in humanoid.arms] == [arm.joints for arm in tuned.arms]
    assert [arm.hand_frame for arm in humanoid.arms] == ["left_rubber_hand", "right_rubber_hand"]
    assert humanoid.file.urdf.held == tuned.file.urdf.held


def test_a_humanoids_arms_hang_clear_of_trunk_and_thighs(humanoid):
    mirror = humanoid.arms[1].mirror
    left, right = (np.array(humanoid.file.posture[arm.name]) for arm in humanoid.arms)
    np.testing.assert_allclose(right, mirror * left)
    np.testing.assert_allclose(left, load_robot("g1").file.posture["left_arm"], atol=0.15)
    shapes = LinkShapes.of(humanoid)
    arms = {joint for arm in humanoid.arms for joint in arm.joint_ids[2:]}
    links = {shape.link for shape in shapes.shapes if shape.joint in arms}
    of_arms = [k for k, pair in enumerate(shapes.pairs) if links & {*pair}]
    assert of_arms
    assert shapes.distances(humanoid.posture)[of_arms].min() > 0.005


def test_a_humanoids_arms_reach_as_far_as_the_tuned_file_has_it(humanoid):
    """From overhead to behind the back, not inward of where they hang."""
    drafted, tuned = humanoid.file.arm_reach, load_robot("g1").file.arm_reach
    np.testing.assert_allclose(drafted.lower, tuned.lower, atol=0.5)
    np.testing.assert_allclose(drafted.upper, tuned.upper, atol=0.4)
    low, high = humanoid.arm_ends
    assert ((humanoid.arm_angles > low) & (humanoid.arm_angles < high)).all()
    assert low[1] > 0  # roll: elbows stay outward


def test_grippers_and_fingers_are_held_too():
    """Talos' arms of seven joints end in a gripper, and its torso carries a head as well."""
    share = package_share(PACKAGE, Path("draft"))
    urdf = share / PACKAGE / "robots" / URDFS["talos"]
    anatomy = draft.read_anatomy(urdf)
    assert [len(arm.joint_ids) for arm in anatomy.arms] == [4, 4]
    assert anatomy.arms[0].hand == "gripper_left_base_link"
    held = [*anatomy.held]
    assert {"arm_left_5_joint", "gripper_right_joint", "head_1_joint", "torso_2_joint"} <= {*held}
    assert len(held) == 12


ARM = """<link name="{side}_arm{k}"><inertial><mass value="{mass}"/><origin xyz="0 0 -0.1"/>
    <inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="{side}_arm{k}_joint" type="revolute"><parent link="{parent}"/>
    <child link="{side}_arm{k}"/><origin xyz="0 {y} {z}"/><axis xyz="{axis}"/>
    <limit lower="-1" upper="1" effort="9" velocity="9"/></joint>"""


def _with_arms(sides, joints, heavier=0.0):
    """SLIDER's URDF with arms of so many joints at its pelvis, the right one heavier by so much."""
    source = (assets_directory() / "slider" / "slider.urdf").read_text()
    links = [
        ARM.format(
            side=side,
            k=k,
            mass=0.5 + heavier * (y < 0),
            parent="pelvis" if k == 0 else f"{side}_arm{k - 1}",
            y=y if k == 0 else 0.0,
            z=0.3 if k == 0 else -0.15,
            axis="1 0 0" if k == 1 else "0 1 0",
        )
        for side, y in sides.items()
        for k in range(joints)
    ]
    return source.replace("</robot>", "".join(links) + "</robot>")


@pytest.mark.parametrize(
    ("sides", "joints", "heavier", "arms"),
    [
        ({"left": 0.2, "right": -0.2}, 3, 0.0, 2),
        ({"left": 0.2, "right": -0.2}, 2, 0.0, 0),
        ({"left": 0.2}, 3, 0.0, 0),
        ({"left": 0.2, "right": -0.25}, 3, 0.0, 0),
        ({"left": 0.2, "right": -0.2}, 3, 0.2, 0),
    ],
    ids=["a pair", "two joints", "one arm", "not mirrored", "one heavier"],
)
def test_arms_are_mirrored_pairs_of_three_joints_or_more(tmp_path, sides, joints, heavier, arms):
    path = tmp_path / "armed.urdf"
    path.write_text(_with_arms(sides, joints, heavier))
    anatomy = draft.read_anatomy(path)
    assert len(anatomy.arms) == arms
    assert len(anatomy.held) == len(sides) * joints - 3 * arms


MIDDLE_ARM = """<link name="{side}_arm{k}"><inertial><mass value="0.5"/>
    <origin xyz="0 {com} 0"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/>
    </inertial></link>
    <joint name="{side}_arm{k}_joint" type="revolute"><parent link="{parent}"/>
    <child link="{side}_arm{k}"/><origin xyz="0 {y} {z}"/><axis xyz="{axis}"/>
    <limit lower="-1.8" upper="1.8" effort="9" velocity="9"/></joint>"""


def test_arms_that_begin_in_the_middle_hang_on_both_sides(tmp_path):
    """Their first joints are at one place, and at zero they point sideways."""
    source = (assets_directory() / "slider" / "slider.urdf").read_text()
    chain = enumerate((("0 1 0", 0.0, 0.5), ("1 0 0", 0.2, 0.0), ("0 0 1", 0.2, 0.0)))
    links = [
        MIDDLE_ARM.format(
            side=side,
            k=k,
            parent="pelvis" if k == 0 else f"{side}_arm{k - 1}",
            axis=axis,
            y=sign * y,
            z=z,
            com=0.2 * sign,
        )
        for k, (axis, y, z) in chain
        for side, sign in (("left", 1), ("right", -1))
    ]
    urdf = tmp_path / "armed.urdf"
    urdf.write_text(source.replace("</robot>", "".join(links) + "</robot>"))
    robot = written(tmp_path / "armed.toml", str(urdf)).robot
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.posture)
    upper, elbows = (
        np.array([data.oMi[arm.joint_ids[k]].translation for arm in robot.arms]) for k in (1, 2)
    )
    assert (elbows[:, 2] < upper[:, 2] - 0.15).all()
    np.testing.assert_allclose(elbows[1], elbows[0] * [1, -1, 1], atol=2e-3)
