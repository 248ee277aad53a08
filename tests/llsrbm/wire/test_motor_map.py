"""Joints to motors and back, against the numbers that the robots' makers publish."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from llsrbm.errors import InputError, RobotFileError
from llsrbm.robots import load_robot
from llsrbm.robots.schema import robot_files
from llsrbm.wire.motor_map import MotorMap

# As published, by number of motor.
UNITREE_LEGS = [
    f"{leg}_{part}_joint" for leg in ("FR", "FL", "RR", "RL") for part in ("hip", "thigh", "calf")
]
G1_FIRST = {0: "left_hip_pitch_joint", 9: "right_knee_joint", 12: "waist_yaw_joint"}
G1_ARMS = {15: "left_shoulder_pitch_joint", 18: "left_elbow_joint", 25: "right_elbow_joint"}
# Of the Solo12 that odri_control_interface configures: HAA, HFE, KFE of FL, FR, HL, HR.
SOLO_NUMBERS = [0, 3, 2, 1, 5, 4, 6, 9, 8, 7, 11, 10]
SOLO_REVERSED = [0, 1, 1, 1, 0, 0, 0, 1, 1, 1, 0, 0]

WITH_WIRE = [name for name, path in robot_files().items() if "[wire]" in path.read_text()]


@pytest.mark.parametrize("name", ["go2"])
def test_quadrupeds_of_unitree_have_their_right_front_hip_first(name):
    motors = MotorMap.of(load_robot(name))
    assert (motors.family, motors.count) == ("unitree_go", 20)
    assert list(motors.joints) == UNITREE_LEGS + [""] * 8
    assert motors.used.tolist() == [True] * 12 + [False] * 8


@pytest.mark.parametrize("name", ["g1", "g1_legs"])
def test_joints_that_are_held_keep_their_motors_at_the_held_angle(name):
    robot = load_robot(name)
    motors = MotorMap.of(robot)
    assert (motors.family, motors.count) == ("unitree_hg", 35)
    for number, joint in {**G1_FIRST, **G1_ARMS}.items():
        assert motors.joints[number] == joint
    q = np.arange(1.0, len(robot.joint_names) + 1)
    at = motors.positions(q)
    speeds, torques = motors.speeds(q), motors.torques(q)
    kp, kd = motors.stiffness(q), motors.damping(q)
    for number, joint in enumerate(motors.joints):
        if joint in robot.file.urdf.held:
            assert at[number] == robot.file.urdf.held[joint]
            assert (speeds[number], torques[number]) == (0, 0)
            assert kp[number] == robot.file.wire.kp[number]
            assert motors.stiffness(q, hold=False)[number] == 0
            assert kd[number] == robot.file.wire.kd[number]
        elif joint:
            moved = q[robot.joint_names.index(joint)]
            assert {at[number], speeds[number], torques[number], kp[number], kd[number]} == {moved}
        else:
            assert not motors.used[number]
            assert at[number] == speeds[number] == torques[number] == kp[number] == kd[number] == 0


def test_solo12_as_its_published_configuration_has_it():
    motors = MotorMap.of(load_robot("solo12"))
    assert (motors.family, motors.count) == ("odri", 12)
    q = np.linspace(-1, 1, 12)
    polarity = np.where(SOLO_REVERSED, -1, 1)
    np.testing.assert_allclose(motors.positions(q)[SOLO_NUMBERS], polarity * 9 * q)
    np.testing.assert_allclose(motors.speeds(q)[SOLO_NUMBERS], polarity * 9 * q)
    np.testing.assert_allclose(motors.torques(q)[SOLO_NUMBERS], polarity * q / 9)
    np.testing.assert_allclose(motors.stiffness(q)[SOLO_NUMBERS], q / 81)
    np.testing.assert_allclose(motors.damping(q)[SOLO_NUMBERS], q / 81)


@pytest.mark.parametrize("name", WITH_WIRE)
@settings(max_examples=10)
@given(seed=st.integers(0, 2**32 - 1), rows=st.integers(1, 3))
def test_there_and_back_is_where_it_began(name, seed, rows):
    robot = load_robot(name)
    motors = MotorMap.of(robot)
    values = np.random.default_rng(seed).normal(size=(rows, len(robot.joint_names)))
    for there, back in (
        (motors.positions, motors.joint_positions),
        (motors.speeds, motors.joint_speeds),
        (motors.torques, motors.joint_torques),
        (motors.stiffness, motors.joint_gains),
        (motors.damping, motors.joint_gains),
    ):
        sent = there(values)
        assert sent.shape == (rows, motors.count)
        np.testing.assert_allclose(back(sent), values, atol=1e-12)


@pytest.mark.parametrize("name", WITH_WIRE)
def test_motors_do_the_joints_work(name):
    """Power is the same on both sides, and so is the torque of a spring."""
    robot = load_robot(name)
    motors = MotorMap.of(robot)
    q, dq, tau = np.random.default_rng(0).normal(size=(3, len(robot.joint_names)))
    np.testing.assert_allclose(motors.torques(tau) @ motors.speeds(dq), tau @ dq)
    spring = motors.stiffness(motors.kp) * (motors.positions(q) - motors.positions(0 * q))
    np.testing.assert_allclose(motors.joint_torques(spring), motors.kp * q)


def changed(tmp_path, robot, old, new):
    text = robot_files()[robot].read_text()
    assert old in text
    path = tmp_path / f"{robot}.toml"
    path.write_text(text.replace(old, new))
    return path


def test_a_zero_that_is_off_shifts_the_motor(tmp_path):
    path = changed(
        tmp_path, "solo12", "gear = 9.0", "gear = 9.0\nzero = [0.1, 0,0,0,0,0,0,0,0,0,0,0]"
    )
    motors = MotorMap.of(load_robot(str(path)))
    at = motors.positions(np.full(12, 0.1))
    assert at[0] == 0  # FL_HAA
    np.testing.assert_allclose(abs(at[1:]), 0.9)


def test_numbers_without_a_motor_are_left_out(tmp_path):
    path = changed(tmp_path, "go2", '"FL_hip_joint", ', '"", "FL_hip_joint", ')
    motors = MotorMap.of(load_robot(str(path)))
    assert motors.joints[2:5] == ("FR_calf_joint", "", "FL_hip_joint")
    assert motors.positions(np.ones(12)).tolist() == [1, 1, 1, 0] + [1] * 9 + [0] * 7


def test_a_robot_without_the_table_has_no_wire():
    with pytest.raises(InputError, match=r"ANYmal B has no table \[wire\] of its motors; expected"):
        MotorMap.of(load_robot("anymal"))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"FR_hip_joint"', '"FR_hip"', r'no joint "FR_hip"; did you mean "FR_hip_joint"\?'),
        ('"FR_hip_joint"', '""', "no motor of FR_hip_joint; expected every joint that moves"),
        ('"FR_hip_joint"', '"FL_hip_joint"', "FL_hip_joint is named twice"),
        ("kp = 60.0", "kp = [60.0, 60.0]", "wire: kp: expected 12 numbers, one a motor, got 2"),
        ('"unitree_go"', '"unitree"', "wire.family: .*'unitree_go', 'unitree_hg' or 'odri'"),
        ("motors = [", "motors = [" + '"",' * 9, "motors: unitree_go has 20, got 21"),
    ],
)
def test_a_mistake_is_named(tmp_path, old, new, message):
    path = changed(tmp_path, "go2", old, new)
    with pytest.raises(RobotFileError, match=message):
        MotorMap.of(load_robot(str(path)))


@pytest.mark.parametrize("name", WITH_WIRE)
def test_no_plan_depends_on_the_wire(tmp_path, name):
    robot = load_robot(name)
    zeros = ", ".join(["0.1"] * len(robot.file.wire.motors))
    other = load_robot(str(changed(tmp_path, name, "kp = ", f"zero = [{zeros}]\nkp = ")))
    assert robot.file != other.file
    assert robot.parameters() == other.parameters()
