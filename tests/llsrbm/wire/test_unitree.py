"""Commands and readings in Unitree's messages: places, signs, gains, and back."""

import numpy as np
import pytest

from llsrbm.control.motor_command import MotorCommand
from llsrbm.control.readings import Readings
from llsrbm.errors import InputError
from llsrbm.robots import load_robot
from llsrbm.wire.unitree import UnitreeMessages
from tests.llsrbm.wire.unitree_reference import checksum

GO2, G1 = load_robot("go2"), load_robot("g1")
HOLDS_ARMS = load_robot("g1_legs")


def random_command(robot, seed):
    return MotorCommand(*np.random.default_rng(seed).uniform(0.1, 9.0, (5, len(robot.joint_names))))


def random_readings(robot, seed, feet):
    rng = np.random.default_rng(seed)
    quat = rng.normal(size=4)
    joints = rng.normal(size=(3, len(robot.joint_names)))
    force = rng.uniform(0, 200, feet) if feet else None
    return Readings(
        12.346, quat / np.linalg.norm(quat), rng.normal(size=3), rng.normal(size=3), *joints, force
    )


def test_go2s_command():
    command = random_command(GO2, 1)
    record = UnitreeMessages(GO2).pack_command(command)
    assert bytes(record["head"]) == b"\xfe\xef"
    assert record["level_flag"] == 0xFF
    motors = record["motor_cmd"]
    assert (motors["mode"] == 1).all()
    at = {name: k for k, name in enumerate(GO2.joint_names)}
    for number, leg in enumerate(("FR", "FL", "RR", "RL")):
        for joint, kind in enumerate(("hip", "thigh", "calf")):
            place = at[f"{leg}_{kind}_joint"]
            for field, value in (
                ("q", command.q), ("dq", command.dq), ("tau", command.tau),
                ("kp", command.kp), ("kd", command.kd),
            ):  # fmt: skip
                assert motors[field][3 * number + joint] == np.float32(value[place])
    assert (motors["q"][12:] == np.float32(2.146e9)).all()
    assert (motors["dq"][12:] == 16000).all()
    assert not motors["kp"][12:].any()
    assert record["crc"] == checksum(record.tobytes())


def test_g1s_command():
    messages = UnitreeMessages(G1)
    state = messages.state_layout.blank()
    state["mode_machine"] = 5
    state["imu_state"]["quaternion"][0] = 1
    messages.readings(state)  # it is told which G1 this is
    command = random_command(G1, 2)
    record = messages.pack_command(command)
    assert record["mode_pr"] == 0
    assert record["mode_machine"] == 5
    assert record["motor_cmd"]["mode"].tolist() == [1] * 29 + [0] * 6
    knee = G1.joint_names.index("right_knee_joint")
    assert record["motor_cmd"]["q"][9] == np.float32(command.q[knee])
    assert record["crc"] == checksum(record.tobytes())


def test_held_joints_are_held_but_for_brakes():
    messages, joints = UnitreeMessages(HOLDS_ARMS), len(HOLDS_ARMS.joint_names)
    following = messages.pack_command(random_command(HOLDS_ARMS, 3))["motor_cmd"]
    torque = messages.pack_command(MotorCommand.of_torque(np.ones(joints)))["motor_cmd"]
    braking = messages.pack_command(MotorCommand.damping(np.ones(joints)))["motor_cmd"]
    arms = slice(15, 29)
    held = HOLDS_ARMS.file.urdf.held["left_elbow_joint"]
    assert following["q"][18] == np.float32(held)
    assert (following["kp"][arms] > 0).all()
    assert (torque["kp"][arms] > 0).all()
    assert not torque["kp"][:12].any()
    assert not braking["kp"].any()
    assert (braking["kd"][:29] > 0).all()


@pytest.mark.parametrize("robot", [GO2, G1, HOLDS_ARMS], ids=lambda robot: robot.name)
def test_a_command_comes_back(robot):
    messages, command = UnitreeMessages(robot), random_command(robot, 4)
    record = messages.pack_command(command)
    back = messages.command(record)
    for name in ("q", "dq", "tau", "kp", "kd"):
        assert getattr(back, name) == pytest.approx(getattr(command, name), rel=1e-6)
    record["motor_cmd"]["q"][0] += 0.1
    assert messages.command(record) is None


def test_loops_that_are_switched_off_do_nothing():
    messages = UnitreeMessages(GO2)
    record = messages.pack_command(random_command(GO2, 5))
    record["motor_cmd"]["q"][0], record["motor_cmd"]["dq"][1] = 2.146e9, 16000.0
    record["motor_cmd"]["mode"][2] = 0
    record["crc"] = checksum(record.tobytes())
    back = messages.command(record)
    hip, thigh, calf = (
        GO2.joint_names.index(f"FR_{kind}_joint") for kind in ("hip", "thigh", "calf")
    )
    torque = back.torque(np.zeros(12), np.ones(12))
    assert back.kp[hip] == back.kd[thigh] == 0
    assert torque[hip] == pytest.approx(back.tau[hip] + back.kd[hip] * (back.dq[hip] - 1))
    assert torque[calf] == 0


@pytest.mark.parametrize(("robot", "feet"), [(GO2, 4), (G1, 0)], ids=["go2", "g1"])
def test_readings_come_back(robot, feet):
    messages, readings = UnitreeMessages(robot), random_readings(robot, 6, feet)
    record = messages.pack_state(readings, 0.9)
    assert record["crc"] == checksum(record.tobytes())
    back = messages.readings(record)
    assert back.time == 12.346
    for name in ("quat", "gyro", "acceleration", "q", "dq", "torque"):
        assert getattr(back, name) == pytest.approx(getattr(readings, name), rel=1e-6)
    if feet:
        assert back.foot_force == pytest.approx(readings.foot_force, abs=1)
        front_right = robot.leg_names.index("FR")
        assert record["foot_force"][0] == int(readings.foot_force[front_right])
        assert messages.health(record).voltage == pytest.approx(0.9 * 28.8)
        assert messages.health(record).charge == 1
    else:
        assert back.foot_force is None
    assert messages.health(record).hottest == 30


def test_other_robots_have_no_such_messages():
    with pytest.raises(InputError, match=r"no table \[wire\]"):
        UnitreeMessages(load_robot("anymal"))
    with pytest.raises(InputError, match=r"wire.family: expected unitree_go or unitree_hg.*odri"):
        UnitreeMessages(load_robot("solo12"))
