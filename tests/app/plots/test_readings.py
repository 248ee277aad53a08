"""Figures of parts as the picture shows them."""

import json

import numpy as np
import pytest

from app.picture.parts import TRUNK
from app.plots.charts import shown_layers
from app.plots.readings import reading
from llsrbm.robots import load_robot
from tests.app.picture.pictures import planned
from tests.llsrbm.synthetic_rollout import synthetic_rollout


@pytest.fixture(scope="module")
def layers():
    motion = planned()
    return shown_layers(motion, synthetic_rollout(motion.plan))


def rows(part, layers):
    read = reading(part, load_robot("anymal"), layers)
    assert json.dumps(read, allow_nan=False)
    return {row["title"]: row for row in read["rows"]}, read["step"]


def test_a_joint_has_an_angle_in_degrees_of_plan_and_simulation(layers):
    found, step = rows("LF_KFE", layers)
    assert found["Angle"]["unit"] == "°"
    plan, simulation = found["Angle"]["lines"]
    assert (plan["title"], simulation["title"]) == ("plan", "simulation")
    motion = planned().motion
    at = load_robot("anymal").joint_names.index("LF_KFE")
    expected = np.degrees(np.interp(30 * step, motion.time, motion.joint_position[:, at]))
    assert plan["values"][30] == pytest.approx(expected, abs=1e-3)


def test_torque_stands_beside_the_share_of_what_is_there(layers):
    found, _ = rows("LF_KFE", layers)
    assert found["Torque"]["unit"] == "Nm"
    assert found["Torque used"]["unit"] == "%"
    # The limit's own line is no motion's.
    assert len(found["Torque used"]["lines"]) == 2


def test_a_foot_has_a_force_and_the_trunk_its_attitude(layers):
    found, _ = rows("LF foot", layers)
    assert [row["unit"] for row in found.values()] == ["N", "N", "N", "m"]
    found, _ = rows(TRUNK, layers)
    assert {"Yaw", "Pitch", "Roll", "Yaw rate"} == set(found)
