"""Exports of a rollout, read back with readers that know nothing of this project."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.formats import export
from tests.llsrbm.formats.jumps import read_table
from tests.llsrbm.synthetic import synthetic_plan
from tests.llsrbm.synthetic_rollout import RATE, synthetic_rollout

LEGS = ("LF", "RF", "LH", "RH")
PHASE = "phase [0 take-off, 1 flight, 2 landing]"


@pytest.fixture(scope="module")
def rollout():
    return synthetic_rollout()


@pytest.fixture(scope="module")
def table(rollout, tmp_path_factory):
    path = tmp_path_factory.mktemp("csv") / "rollout.csv"
    export(rollout, path, format="csv")
    return read_table(path)


@pytest.fixture(scope="module")
def ticks(rollout, tmp_path_factory):
    path = tmp_path_factory.mktemp("csv") / "ticks.csv"
    export(rollout, path, format="csv", fps=RATE)
    return read_table(path)


def columns(table, name, unit, axes="xyz"):
    return np.stack([table[f"{name}/{axis} [{unit}]"] for axis in axes], axis=1)


def test_every_column_has_a_unit_and_time_is_first(table):
    assert next(iter(table)) == "time [s]"
    bare = [name for name in table if not name.endswith("]")]
    names = ("base_quat", "reference_base_quat")
    assert bare == [f"{name}/{axis}" for name in names for axis in "wxyz"]


def test_what_plans_have_too_is_called_the_same(table, tmp_path):
    export(synthetic_plan(), tmp_path / "plan.csv", format="csv")
    missing = set(read_table(tmp_path / "plan.csv")) - set(table)
    of_the_model = ("com_velocity", "foot_quat", "contact_point", "leg_com")
    assert {name.split("/")[0] for name in missing} == set(of_the_model)


def test_at_60_fps_with_a_row_for_every_event(rollout, table):
    time = table["time [s]"]
    assert (time[0], time[-1]) == (0.0, 2.5)
    assert np.diff(time).max() < 1 / 60 + 1e-9
    assert len(time) < 2.5 * 60 + 7
    first = {
        "true": time[
            np.argmax((table["contact/LF [0 in the air, 1 touches]"] == 1) & (table[PHASE] == 1))
        ],
        "detected": time[np.argmax(table["mode [0 tracking, 1 force]"] == 1)],
    }
    assert first["true"] == pytest.approx(rollout.outcome.touchdown_true_s)
    assert first["detected"] == pytest.approx(rollout.outcome.touchdown_detected_s)


def test_at_the_control_rate_rows_are_ticks(rollout, ticks):
    np.testing.assert_allclose(ticks["time [s]"], rollout.time, atol=1e-11)
    for name, unit, values in (
        ("com", "m", rollout.com),
        ("base_position", "m", rollout.qpos[:, :3]),
        ("base_velocity", "m/s", rollout.qvel[:, :3]),
        ("linear_momentum", "kg m/s", rollout.linear_momentum),
        ("angular_momentum", "kg m2/s", rollout.angular_momentum),
        ("reference_com", "m", rollout.reference_com),
        ("foot_position/RH", "m", rollout.foot_position[:, 3]),
        ("contact_force/RF", "N", rollout.contact_force[:, 1]),
    ):
        np.testing.assert_allclose(columns(ticks, name, unit), values, rtol=1e-11, atol=1e-11)
    for i, joint in enumerate(rollout.joint_names):
        for name, unit, values in (
            ("joint_position", "rad", rollout.qpos[:, 7 + i]),
            ("joint_velocity", "rad/s", rollout.qvel[:, 6 + i]),
            ("joint_torque", "Nm", rollout.torque[:, i]),
            ("joint_torque_limit", "Nm", rollout.torque_limit[:, i]),
        ):
            got = ticks[f"{name}/{joint} [{unit}]"]
            np.testing.assert_allclose(got, values, rtol=1e-11, atol=1e-11)
    for i, leg in enumerate(LEGS):
        np.testing.assert_array_equal(
            ticks[f"contact/{leg} [0 in the air, 1 touches]"], rollout.contact[:, i]
        )
    norm = ticks["average_spatial_velocity_norm [m/s and rad/s]"]
    np.testing.assert_allclose(norm, rollout.average_spatial_velocity_norm, rtol=1e-11)
    np.testing.assert_allclose(
        ticks["detection_signal [the detector's]"], rollout.detection_signal, rtol=1e-11
    )


def test_angular_velocity_is_in_world_axes(rollout, tmp_path):
    """MuJoCo's is in the base's."""
    tilted = Rotation.from_euler("xyz", [0.4, -0.3, 1.0])
    qpos, qvel = rollout.qpos.copy(), rollout.qvel.copy()
    quat = np.tile(tilted.as_quat(scalar_first=True), (len(qpos), 1))
    qpos[:, 3:7] = quat
    qvel[:, 3:6] = [1.0, 2.0, 3.0]
    export(replace(rollout, qpos=qpos, qvel=qvel, base_quat=quat), tmp_path / "x.csv", format="csv")
    omega = columns(read_table(tmp_path / "x.csv"), "angular_velocity", "rad/s")
    np.testing.assert_allclose(omega, omega[:1].repeat(len(omega), axis=0))
    np.testing.assert_allclose(omega[0], tilted.apply([1.0, 2.0, 3.0]))
