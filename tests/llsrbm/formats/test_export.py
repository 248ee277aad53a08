"""Exports, read back with readers that know nothing of this project."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.formats import export
from tests.llsrbm.formats.jumps import read_table
from tests.llsrbm.synthetic import FLIGHT, JOINT_NAMES, synthetic_plan


@pytest.fixture(scope="module")
def plan():
    # Signs that flip from knot to knot are the same attitudes.
    plan = synthetic_plan(twist=np.pi)
    sign = np.where(np.arange(len(plan.time)) % 2, -1.0, 1.0)
    return replace(plan, base_quat=plan.base_quat * sign[:, None])


@pytest.fixture(scope="module")
def table(plan, tmp_path_factory):
    path = tmp_path_factory.mktemp("csv") / "motion.csv"
    export(plan, path, format="csv")
    return read_table(path)


def columns(table, name, axes="xyz"):
    found = [
        next(v for key, v in table.items() if re.fullmatch(rf"{name}/{axis}( \[.*\])?", key))
        for axis in axes
    ]
    return np.stack(found, axis=1)


def test_every_column_has_a_unit_and_time_is_first(table):
    assert next(iter(table)) == "time [s]"
    bare = [name for name in table if not name.endswith("]")]
    quats = ["base_quat", *(f"foot_quat/{leg}" for leg in ("LF", "RF", "LH", "RH"))]
    assert bare == [f"{quat}/{axis}" for quat in quats for axis in "wxyz"]


def test_time_runs_from_start_to_end_at_60_fps(plan, table):
    time = table["time [s]"]
    assert time[0] == plan.time[0]
    assert time[-1] == pytest.approx(plan.time[-1], abs=1e-9)
    assert (np.diff(time) > 0).all()
    assert np.diff(time).max() < 1 / 60 + 1e-9


def test_lift_off_and_touch_down_have_their_rows(plan, table):
    phase = table["phase [0 take-off, 1 flight, 2 landing]"]
    for number, start in enumerate(plan.phase_start[:-1]):
        first = np.argmax(phase == number)
        assert table["time [s]"][first] == pytest.approx(start, abs=1e-9)
    flight = phase == FLIGHT
    for leg in ("LF", "RF", "LH", "RH"):
        force = columns(table, f"contact_force/{leg}")
        assert (force[flight] == 0).all()
        assert (np.abs(force[~flight]).max(axis=1) > 0).all()


def test_quaternion_is_w_first_and_continuous(plan, table):
    quat = columns(table, "base_quat", "wxyz")
    assert (np.sum(quat[1:] * quat[:-1], axis=1) > 0.9).all()
    yaw = np.unwrap(Rotation.from_quat(quat, scalar_first=True).as_euler("zyx")[:, 0])
    assert yaw[0] == pytest.approx(0, abs=1e-9)
    assert yaw[-1] == pytest.approx(np.pi, abs=1e-9)


def test_values_at_the_ends(plan, table):
    for row, knot in ((0, 0), (-1, -1)):
        for name in ("com", "base_position", "linear_momentum", "angular_momentum"):
            got = columns(table, name)[row]
            np.testing.assert_allclose(got, getattr(plan, name)[knot], rtol=1e-11, atol=1e-11)
        for i, leg in enumerate(("LF", "RF", "LH", "RH")):
            got = columns(table, f"foot_position/{leg}")[row]
            np.testing.assert_allclose(got, plan.foot_position[knot, i], rtol=1e-11, atol=1e-11)
        for i, joint in enumerate(JOINT_NAMES):
            got = table[f"joint_position/{joint} [rad]"][row]
            assert got == pytest.approx(plan.joint_position[knot, i], abs=1e-9)
            for name in ("joint_torque", "joint_torque_limit"):
                got = table[f"{name}/{joint} [Nm]"][row]
                assert got == pytest.approx(getattr(plan, name)[knot, i], abs=1e-9)
        assert table["inertia/xy [kg m2]"][row] == pytest.approx(plan.inertia[knot, 0, 1])


def test_torques_hold_over_an_interval(plan, table):
    """As the contact forces do."""
    time = table["time [s]"]
    between = np.abs(time[:, None] - plan.time).min(axis=1) > 1e-6
    at = np.searchsorted(plan.time, time[between], side="right") - 1
    got = table[f"joint_torque/{JOINT_NAMES[5]} [Nm]"][between]
    np.testing.assert_allclose(got, plan.joint_torque[at, 5], rtol=1e-9, atol=1e-9)


def test_robots_that_the_file_does_not_describe(plan, tmp_path):
    export(replace(plan, robot_parameters={}), tmp_path / "x.csv", format="csv")
    header = (tmp_path / "x.csv").read_text().splitlines()[0]
    assert "foot_position/leg3/z [m]" in header


def test_planar_feet_have_numbered_corners(plan, tmp_path):
    corners = np.repeat(plan.contact_point, 4, axis=1)
    plan = replace(plan, contact_point=corners, contact_force=np.repeat(plan.contact_force, 4, 1))
    export(plan, tmp_path / "x.csv", format="csv")
    header = (tmp_path / "x.csv").read_text().splitlines()[0]
    assert "contact_force/RH_3/z [N]" in header
