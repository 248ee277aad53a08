"""Limbs that never stand: mirrored onto the first one, part of the trunk where they are held."""

import re

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from llsrbm.errors import RobotFileError
from llsrbm.robots import load_robot
from llsrbm.robots.schema import read_robot_file, robot_files
from tests.llsrbm.robots.mistakes import check_one_clear_line

G1 = robot_files()["g1"].read_text()
MIRROR = np.array([1.0, -1.0, 1.0])
# Rows of the file, whatever their numbers are.
LEFT_ARM, RIGHT_ARM = (rf"{side}_arm = \{{.*\}}" for side in ("left", "right"))
RIGHT_POSTURE = r"right_arm = \[.*\]"
UPPER = r"upper = \[[^,]*, [^,]*, [^,]*, [^,]*\]"  # of the arms, whose joints are four
STRAIGHT = 2e-3  # m to which the URDF's arms are mirror images


def _with(row, changed):
    """G1's file with a row, a regular expression, in another way."""
    text, count = re.subn(rf"(?m)^{row}$", changed, G1)
    assert count == 1
    return text


def _hands(robot, angles):
    """(A, 3) m of the hands in the base frame, arms at angles (A, n)."""
    q = pin.neutral(robot.model)
    q[7 + robot.arm_joint_index] = np.ravel(angles)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    return np.array([data.oMf[arm.hand_frame_id].translation for arm in robot.arms])


@pytest.mark.parametrize("name", ["g1", "talos"])
@given(share=st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4))
@settings(max_examples=10)
def test_mirrored_angles_bring_hands_to_mirrored_places(name, share):
    robot = load_robot(name)
    low, high = robot.arm_ends[:, :4]
    first = low + np.array(share) * (high - low)
    left, right = _hands(robot, [first, first * robot.arms[1].mirror])
    np.testing.assert_allclose(right, MIRROR * left, atol=STRAIGHT)


def test_signs_come_from_the_axes():
    """Pitch axes are those of the other side, roll and yaw turn the other way."""
    arms = load_robot("g1").arms
    assert [arm.name for arm in arms] == ["left_arm", "right_arm"]
    assert arms[0].mirror.tolist() == [1, 1, 1, 1]
    assert arms[1].mirror.tolist() == [1, -1, -1, 1]
    assert arms[0].joints[-1] == "left_elbow_joint"


def test_ends_are_mirrored_and_within_the_stops():
    robot = load_robot("g1")
    reach = robot.file.arm_reach
    (low, high), (lower, upper) = robot.arm_ends, robot.joint_stops[:, robot.arm_joint_index]
    assert (low >= lower).all()
    assert (high <= upper).all()
    np.testing.assert_array_equal(low[:4], reach.lower)
    np.testing.assert_array_equal(high[:4], reach.upper)
    mirror = robot.arms[1].mirror
    np.testing.assert_array_equal(
        low[4:], np.where(mirror > 0, reach.lower, np.negative(reach.upper))
    )
    assert ((robot.arm_angles > low) & (robot.arm_angles < high)).all()


def test_stops_end_a_reach_that_is_wider(tmp_path):
    path = tmp_path / "wide.toml"
    path.write_text(_with(UPPER, "upper = [1.0, 9.0, 1.0, 1.9]"))
    low, high = load_robot(str(path)).arm_ends
    assert high[1] == pytest.approx(2.2515)
    assert low[5] == pytest.approx(-2.2515)


def test_the_trunk_is_the_base_of_the_robot_whose_arms_are_held(tmp_path):
    free = load_robot("g1")
    at = zip([name for arm in free.arms for name in arm.joints], free.arm_angles, strict=True)
    rows = "\n".join(f"{name} = {float(angle)}" for name, angle in at)
    text = re.sub(r"(?m)^(?:left|right)_arm = .*\n|^\[arms\]\n", "", G1)
    text = re.sub(r"(?s)\[(arm_reach|drives\.arms)\].*?\n\n", "", text)
    path = tmp_path / "held.toml"
    path.write_text(text.replace("[urdf.held]", f"[urdf.held]\n{rows}"))
    held = load_robot(str(path))
    assert held.arms == ()
    assert free.mass == pytest.approx(held.mass)
    assert free.base.mass < 0.7 * held.base.mass
    assert free.trunk.mass == pytest.approx(held.base.mass)
    np.testing.assert_allclose(free.trunk.lever, held.base.lever, atol=1e-9)
    np.testing.assert_allclose(free.trunk.inertia, held.base.inertia, atol=1e-9)
    assert held.trunk.mass == held.base.mass


def test_robots_without_arms_have_none():
    robot = load_robot("g1_legs")
    assert robot.arms == ()
    assert robot.arm_joint_index.shape == robot.arm_angles.shape == (0,)
    assert robot.arm_ends.shape == (2, 0)


MISTAKES = {
    "no such hand": (
        LEFT_ARM,
        'left_arm = { hand = "left_hnd" }',
        ["arms.left_arm.hand", 'no frame "left_hnd"', 'did you mean "left_hand"?'],
    ),
    "a hand on the base": (
        LEFT_ARM,
        'left_arm = { hand = "torso_link" }',
        ["arms.left_arm.hand", "no joint moves", "at the end of an arm"],
    ),
    "the same arm twice": (
        RIGHT_ARM,
        'right_arm = { hand = "left_rubber_hand" }',
        ["arms.right_arm", '"left_shoulder_pitch_joint"', "also belongs to limb left_arm"],
    ),
    "an arm that is forgotten": (
        RIGHT_ARM,
        "",
        ["posture.right_arm: no such leg or arm", "left, right, left_arm"],
    ),
    "posture of an arm missing": (RIGHT_POSTURE, "", ["posture.right_arm: missing"]),
    "too few angles": (
        RIGHT_POSTURE,
        "right_arm = [0.2, 0.2, 0.0]",
        ["posture.right_arm: expected 4 angles, as arm_reach has"],
    ),
    "a wrist that is neither held nor stated": (
        r"left_wrist_yaw_joint = .*",
        "",
        ["posture.left_arm: expected 5 joint angles", "left_wrist_yaw_joint", "got 4"],
    ),
    "a reach turned round": (
        UPPER,
        "upper = [1.0, -9.0, 1.0, 1.9]",
        ["arm_reach", "none above its upper one"],
    ),
    "no reach": (
        rf"\[arm_reach\]\n.*\n{UPPER}",
        "",
        ["arm_reach: expected for robots with [arms]"],
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_about_arms_is_one_clear_line(tmp_path, mistake):
    right, wrong, expected = MISTAKES[mistake]
    check_one_clear_line(tmp_path / "mine.toml", _with(right, wrong), expected)


def test_an_arm_called_like_a_leg_is_refused(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(re.sub(r"(?m)^right_arm =(?= \{)", "right =", G1).replace("right_arm =", "# "))
    with pytest.raises(RobotFileError, match=r"arms\.right: a leg is called so, too"):
        load_robot(str(path))


def test_a_reach_without_arms_is_refused(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(
        robot_files()["g1_legs"].read_text() + "\n[arm_reach]\nlower = [0.0]\nupper = [1.0]\n"
    )
    with pytest.raises(RobotFileError, match=r"arm_reach: expected for robots with .* no others"):
        read_robot_file(path)
