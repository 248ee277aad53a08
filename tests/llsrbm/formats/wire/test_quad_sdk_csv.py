"""Leg commands, put back into messages by the paths in the header."""

import re

import numpy as np
import pytest

from llsrbm.errors import InputError
from llsrbm.formats import export
from llsrbm.installed import assets_directory
from llsrbm.motion.plan import load_plan
from tests.llsrbm.formats.wire.jumps import jump, rate_of, read_table, torques_of

# quad_msgs: LegCommandArray has FL, BL, FR, BR; LegCommand abduction, hip, knee; MotorCommand
# these fields.
LEGS = ("FL", "RL", "FR", "RR")
FIELDS = {"pos_setpoint", "vel_setpoint", "kp", "kd", "torque_ff"}
PATH = re.compile(r"leg_commands\[(\d)\]\.motor_commands\[(\d)\]\.(\w+)")


@pytest.fixture(scope="module")
def path(kind, tmp_path_factory):
    path = tmp_path_factory.mktemp("quad-sdk") / "jump.csv"
    export(jump("go2", kind), path, format="quad-sdk-csv", fps=rate_of("go2"))
    return path


def message(path):
    """time, and leg -> motor -> field -> (K,)."""
    table = read_table(path)
    time = table.pop("time")
    legs = {}
    for name, column in table.items():
        leg, motor, field = PATH.fullmatch(name).groups()
        legs.setdefault(int(leg), {}).setdefault(int(motor), {})[field] = column
    return time, legs


def test_motors_get_what_their_joints_do(kind, path):
    time, legs = message(path)
    trajectory = jump("go2", kind)
    assert sorted(legs) == [0, 1, 2, 3]
    for number, leg in enumerate(LEGS):
        assert sorted(legs[number]) == [0, 1, 2]
        for motor, part in enumerate(("hip", "thigh", "calf")):
            joint, given = f"{leg}_{part}_joint", legs[number][motor]
            assert set(given) == FIELDS
            column = trajectory.joint_names.index(joint)
            if kind == "rollout":
                ticks = np.arange(0, len(trajectory.time), 2)
                q, dq = (given[name][: len(ticks)] for name in ("pos_setpoint", "vel_setpoint"))
                np.testing.assert_allclose(q, trajectory.joint_position[ticks, column], atol=1e-6)
                np.testing.assert_allclose(dq, trajectory.joint_velocity[ticks, column], atol=1e-5)
            ends = trajectory.joint_position[[0, -1], column]
            np.testing.assert_allclose(given["pos_setpoint"][[0, -1]], ends, atol=1e-6)
            inside = time < trajectory.time[-1] - trajectory.time[0]
            wanted = torques_of(trajectory, joint, time[inside])
            np.testing.assert_allclose(given["torque_ff"][inside], wanted, atol=1e-4)
            assert set(given["kp"]) == {60}
            assert set(given["kd"]) == {3}


def test_a_biped_has_no_such_legs(tmp_path):
    plan = load_plan(assets_directory() / "plans" / "g1.npz")
    with pytest.raises(InputError, match="g1 is no quadruped; expected one with a leg of 3 joints"):
        export(plan, tmp_path / "x.csv", format="quad-sdk-csv")
    assert not list(tmp_path.iterdir())
