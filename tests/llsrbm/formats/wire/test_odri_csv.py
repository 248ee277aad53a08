"""Solo12's table, read as odri_control_interface's five calls take it."""

import numpy as np
import pytest

from llsrbm.errors import InputError
from llsrbm.formats import export
from tests.llsrbm.formats.jumps import planned, read_table
from tests.llsrbm.formats.wire.jumps import beside, check_joint, jump, rate_of

# Of its published configuration of Solo12.
JOINTS = [f"{leg}_{part}" for leg in ("FL", "FR", "HL", "HR") for part in ("HAA", "HFE", "KFE")]
NUMBERS = [0, 3, 2, 1, 5, 4, 6, 9, 8, 7, 11, 10]
REVERSED = [False, True, True, True, False, False] * 2
CALLS = ("position", "velocity", "torque", "kp", "kd")


@pytest.fixture(scope="module")
def path(kind, tmp_path_factory):
    path = tmp_path_factory.mktemp("odri") / "jump.csv"
    export(jump("solo12", kind), path, format="odri-csv", fps=rate_of("solo12"))
    return path


def calls(path):
    """time, and for each call its (K, 12) arguments, as a program slices rows of numbers."""
    rows = np.loadtxt(path, delimiter=",", skiprows=1)
    assert rows.shape[1] == 1 + 5 * 12
    return rows[:, 0], dict(zip(CALLS, np.split(rows[:, 1:], 5, axis=1), strict=True))


def test_joints_get_what_they_do(kind, path):
    time, given = calls(path)
    for number, joint in enumerate(JOINTS):
        q, dq, tau = (given[call][:, number] for call in ("position", "velocity", "torque"))
        check_joint("solo12", kind, joint, time, q, dq, tau, torque_tolerance=1e-5)
    np.testing.assert_array_equal(given["kp"], 5)
    np.testing.assert_array_equal(given["kd"], 0.1)


def test_the_header_says_so(path):
    table = read_table(path)
    assert list(table) == ["time", *(f"{call}/{joint}" for call in CALLS for joint in JOINTS)]


def test_the_configuration_is_the_published_one(path):
    told = beside(path)
    assert told["joint_order"] == JOINTS
    assert told["motor_numbers"] == NUMBERS
    assert told["reverse_polarities"] == REVERSED
    assert told["gear_ratios"] == [9.0] * 12
    assert told["motor_constants"] == [0.025] * 12
    assert told["max_currents"] == [8.0] * 12
    largest = np.abs(calls(path)[1]["torque"]).max(axis=0) / (9 * 0.025)
    np.testing.assert_allclose(told["largest_currents"], largest, rtol=1e-6)


def test_1000_rows_a_second(tmp_path):
    export(planned("solo12"), tmp_path / "x.csv", format="odri-csv")
    np.testing.assert_allclose(np.diff(calls(tmp_path / "x.csv")[0]), 0.001, atol=1e-7)


def test_robots_of_others(tmp_path):
    with pytest.raises(InputError, match="messages of family unitree_go; expected odri"):
        export(planned("go2"), tmp_path / "x.csv", format="odri-csv")
    assert not list(tmp_path.iterdir())
