"""Leg commands, put back into messages by the paths in the header."""

import re

import pytest

from llsrbm.errors import InputError
from llsrbm.formats import export
from tests.llsrbm.formats.jumps import read_table, shipped
from tests.llsrbm.formats.wire.jumps import check_joint, jump, rate_of

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
    assert sorted(legs) == [0, 1, 2, 3]
    for number, leg in enumerate(LEGS):
        assert sorted(legs[number]) == [0, 1, 2]
        for motor, part in enumerate(("hip", "thigh", "calf")):
            given = legs[number][motor]
            assert set(given) == FIELDS
            q, dq, tau = (given[name] for name in ("pos_setpoint", "vel_setpoint", "torque_ff"))
            check_joint("go2", kind, f"{leg}_{part}_joint", time, q, dq, tau)
            assert set(given["kp"]) == {60}
            assert set(given["kd"]) == {3}


def test_a_biped_has_no_such_legs(tmp_path):
    with pytest.raises(InputError, match="g1 is no quadruped; expected one with a leg of 3 joints"):
        export(shipped("g1"), tmp_path / "x.csv", format="quad-sdk-csv")
    assert not list(tmp_path.iterdir())
