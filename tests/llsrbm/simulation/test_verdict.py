"""How far a base is turned away, upright and far from it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.request.jump import Jump
from llsrbm.simulation.verdict import _yaw_error, fallen
from llsrbm.simulation.world import TickResult
from tests.app.synthetic_plan import synthetic_plan

PLAN = synthetic_plan(Jump(twist=1.2))
NOTHING = TickResult.unknown(4, 12)  # touched


def quat(*turns: Rotation) -> np.ndarray:
    """Of rotations one after the other, the last first, w first."""
    whole = Rotation.identity()
    for turn in turns:
        whole = whole * turn
    return whole.as_quat(scalar_first=True)


def about(axis: str, degrees: float) -> Rotation:
    return Rotation.from_euler(axis, degrees, degrees=True)


@pytest.mark.parametrize("pitch", [-360.0, 0.0, 20.0, 360.0])
def test_yaw_error_is_the_headings_difference_near_upright(pitch):
    actual = quat(about("z", 80.0), about("y", pitch))
    wanted = np.degrees(1.2)
    error = _yaw_error(actual[None], 0, PLAN, -1)
    assert np.degrees(error) == pytest.approx(80.0 - wanted, abs=1e-6)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_yaw_error_of_an_upside_down_base_is_the_turn_from_its_plan(sign):
    """A heading jumps by 180 deg where the nose passes the vertical; this does not."""
    planned = np.tile(quat(about("y", 170.0)), (len(PLAN.time), 1))
    plan = replace(PLAN, base_quat=planned)
    actual = sign * quat(about("z", 12.0), about("y", 170.0))
    assert np.degrees(_yaw_error(actual[None], 0, plan, -1)) == pytest.approx(12.0)


@pytest.mark.parametrize(
    ("pitch", "planned", "falls"),
    [(59.0, 0.0, False), (61.0, 0.0, True), (180.0, 180.0, False), (0.0, 120.0, True)],
)
def test_a_robot_topples_away_from_where_it_should_be(pitch, planned, falls):
    q = np.zeros(19)
    q[3:7] = about("y", pitch).as_quat()
    fall = fallen(1.0, q, about("y", planned).as_matrix(), NOTHING)
    assert (fall is not None) == falls


def test_what_touches_a_hurdle_has_not_jumped_over_it():
    q = np.zeros(19)
    q[6] = 1.0
    fall = fallen(1.0, q, np.eye(3), replace(NOTHING, obstacle_contact=True))
    assert fall is not None
    assert fall.reason == "it touched the hurdle"
