"""Tables for LowCmd, put into the messages' own layout and compared joint by joint."""

import re
import struct
from dataclasses import replace

import numpy as np
import pytest

from llsrbm.errors import InputError
from llsrbm.formats import export
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import planned, read_table, shipped, simulated
from tests.llsrbm.formats.wire.jumps import beside, check_joint, jump, rate_of
from tests.llsrbm.wire.unitree_reference import checksum

# As published: a motor's command in the messages of both families, and who has which number.
MOTOR = np.dtype([("q", "<f4"), ("dq", "<f4"), ("tau", "<f4"), ("kp", "<f4"), ("kd", "<f4")])
GO2 = [
    f"{leg}_{part}_joint" for leg in ("FR", "FL", "RR", "RL") for part in ("hip", "thigh", "calf")
]
LEG = ("hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll")
ARM = (
    "shoulder_pitch",
    "shoulder_roll",
    "shoulder_yaw",
    "elbow",
    "wrist_roll",
    "wrist_pitch",
    "wrist_yaw",
)
G1 = [
    *(f"{side}_{part}_joint" for side in ("left", "right") for part in LEG),
    *(f"waist_{part}_joint" for part in ("yaw", "roll", "pitch")),
    *(f"{side}_{part}_joint" for side in ("left", "right") for part in ARM),
]


def messages(path, motors):
    """(time, motor_cmd (K, motors)): every number of the table in its motor's field."""
    table = read_table(path)
    time = table.pop("time")
    commands = np.zeros((len(time), motors), dtype=MOTOR)
    for name, column in table.items():
        part, number = re.fullmatch(r"(q|dq|tau|kp|kd)_(\d+)", name).groups()
        commands[part][:, int(number)] = column
    return time, commands


@pytest.fixture(scope="module")
def sent(kind, tmp_path_factory):
    path = tmp_path_factory.mktemp("lowcmd") / "jump.csv"
    export(jump("go2", kind), path, format="lowcmd", fps=rate_of("go2"))
    return messages(path, 20)


def test_motors_get_what_their_joints_do(kind, sent):
    time, commands = sent
    assert commands.shape[1] == 20
    for number, joint in enumerate(GO2):
        q, dq, tau = (commands[part][:, number] for part in ("q", "dq", "tau"))
        check_joint("go2", kind, joint, time, q, dq, tau)
    np.testing.assert_array_equal(commands["kp"][:, :12], 60)
    np.testing.assert_array_equal(commands["kd"][:, :12], 3)
    assert not commands[:, 12:].view("<f4").any()  # left idle


def test_torques_jump_where_the_feet_leave(tmp_path):
    plan = planned("go2")
    export(plan, tmp_path / "x.csv", format="lowcmd", fps=1000)
    time, commands = messages(tmp_path / "x.csv", 20)
    knees = commands["tau"][:, 2:12:3]
    first = int(np.argmax(time >= plan.lift_off))
    assert time[first] - plan.lift_off < 1e-3
    # The legs push until the row before and are only swung from this one on.
    joints = [plan.joint_names.index(joint) for joint in GO2[2::3]]
    knots = plan.joint_torque[:, joints]
    edge = int(np.argmax(plan.time >= plan.lift_off - 1e-9))
    np.testing.assert_allclose(knees[first - 1], knots[edge - 1], atol=1e-4)
    np.testing.assert_allclose(knees[first], knots[edge], atol=1e-4)
    assert np.abs(knees[first] - knees[first - 1]).max() > 1


def test_500_rows_a_second_and_standing_before_and_after(tmp_path):
    plan = planned("go2")
    export(plan, tmp_path / "x.csv", format="lowcmd", pad=0.1)
    time, commands = messages(tmp_path / "x.csv", 20)
    np.testing.assert_allclose(np.diff(time), 0.002, atol=1e-7)
    assert time[0] == 0
    assert time[-1] == pytest.approx(plan.duration + 0.2, abs=0.002)
    for rows in (slice(None, 50), slice(-50, None)):
        assert not commands["dq"][rows].any()
        assert not np.ptp(commands["q"][rows], axis=0).any()


def test_what_stands_beside(tmp_path):
    export(simulated("go2"), tmp_path / "x.csv", format="lowcmd")
    told = beside(tmp_path / "x.csv")
    assert told["fps"] == 500
    assert told["family"] == "unitree_go"
    assert told["motors"] == [{"number": n, "joint": joint} for n, joint in enumerate(GO2)]
    assert told["columns"] == list(read_table(tmp_path / "x.csv"))
    assert dict(zip(told["columns"], told["column_units"], strict=True))["kd_11"] == "Nm s/rad"
    assert told["request"]["twist"] == planned("go2").jump.twist


def test_g1s_held_joints_stay(tmp_path):
    plan = shipped("g1")
    export(plan, tmp_path / "x.csv", format="lowcmd", fps=100)
    _, commands = messages(tmp_path / "x.csv", 35)
    held = load_robot("g1").file.urdf.held
    assert [motor["joint"] for motor in beside(tmp_path / "x.csv")["motors"]] == G1
    for number, joint in enumerate(G1):
        here = commands[:, number]
        assert (here["kp"] > 0).all()
        assert (here["kd"] > 0).all()
        if joint in held:
            np.testing.assert_array_equal(here["q"], np.float32(held[joint]))
            assert not here["dq"].any()
            assert not here["tau"].any()
        else:
            assert here["q"][0] == pytest.approx(
                plan.joint_position[0, plan.joint_names.index(joint)], abs=1e-6
            )
            assert np.ptp(here["q"]) > 1e-6
    assert not commands[:, 29:].view("<f4").any()


# The structures of Unitree's SDK as a C compiler lays them out.
GO = "<4B4IH2x" + "B3x5f3I" * 20 + "4B55Bx2I"
HG = "<2B2x" + "B3x5fI" * 35 + "5I"


@pytest.mark.parametrize(
    ("robot", "form", "head", "each", "motors"),
    [("go2", GO, 9, 9, GO2), ("g1", HG, 2, 7, G1)],
)
def test_packed_messages_hold_the_table(tmp_path, robot, form, head, each, motors):
    plan = shipped(robot)
    export(plan, tmp_path / "x.csv", format="lowcmd", fps=20, packed=True)
    time, commands = messages(tmp_path / "x.csv", len(motors))
    packed = (tmp_path / "x.csv.messages").read_bytes()
    size = struct.calcsize(form)
    assert size == {"go2": 812, "g1": 1004}[robot]
    assert len(packed) == size * len(time)
    for k in range(len(time)):
        message = packed[k * size : (k + 1) * size]
        fields = struct.unpack(form, message)
        if robot == "go2":
            assert fields[:3] == (0xFE, 0xEF, 0xFF)
        for number in range(len(motors)):
            mode, *five = fields[head + each * number : head + each * number + 6]
            assert mode == 1
            wanted = [float(commands[part][k, number]) for part in MOTOR.names]
            np.testing.assert_allclose(five, wanted, rtol=1e-6, atol=1e-8)
        assert fields[-1] == checksum(message)
    assert beside(tmp_path / "x.csv")["packed"] is True


@pytest.mark.parametrize(
    ("robot", "message"),
    [("solo12", "family odri and no LowCmd"), ("anymal", r"ANYmal B has no table \[wire\]")],
)
def test_robots_of_others(tmp_path, robot, message):
    with pytest.raises(InputError, match=message):
        export(shipped(robot), tmp_path / "x.csv", format="lowcmd")
    assert not list(tmp_path.iterdir())


def test_a_plan_without_torques(tmp_path):
    plan = replace(planned("go2"), joint_torque=None)
    with pytest.raises(InputError, match="has no torques; expected one that was solved"):
        export(plan, tmp_path / "x.csv", format="lowcmd")
