"""What the whole body makes of a plan's turn, against what the model says."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.planning.problem.constraints.truth import (
    BEARABLE,
    OVER,
    TrueTurn,
    TurnsOver,
    turn_error,
)
from tests.llsrbm.planning.solved import TYPES, changed, solved, variable


@pytest.mark.parametrize("request_name", ["all", *TYPES])
def test_plans_of_the_true_model_turn_as_they_say(request_name):
    knots = solved("llsrbm-plus", request_name).knots
    for flight in knots.flights:
        assert np.linalg.norm(turn_error(knots, flight)) < np.radians(2.0)
    assert TrueTurn().violation(knots).max() == 0


def test_momentum_that_the_body_does_not_have_is_seen():
    """Twice the momentum turns the body by about as much again."""
    knots = solved("llsrbm-plus", "twist").knots
    (flight,) = knots.flights
    inside = range(flight.start, flight.stop)
    doubled = changed(knots, *(("momentum", k, 2 * variable(knots, "momentum", k)) for k in inside))
    turned = np.linalg.norm(turn_error(doubled, flight))
    turn = np.linalg.norm(knots.rotation_rate[flight].T @ knots.dt[flight])
    assert turned == pytest.approx(turn, rel=0.25)
    assert TrueTurn().violation(doubled).max() == pytest.approx(turned - BEARABLE)


def test_models_for_comparison_are_not_held_to_it():
    assert TrueTurn().violation(solved("srbm", "twist").knots).max() == 0


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_half_a_twist_is_no_flip(axis):
    """A whole turn about x or y is upside down on its way, one about z is not."""
    turn = Rotation.from_euler(axis, np.linspace(0.0, 360.0, 13)[:, None], degrees=True)
    quat = turn.as_quat(scalar_first=True)
    knots = SimpleNamespace(
        time=np.arange(13.0), quat=quat, flights=[slice(2, 9)], layout=SimpleNamespace(turns=True)
    )
    expected = np.zeros(13)
    expected[9] = OVER if axis == "z" else 0.0
    np.testing.assert_allclose(TurnsOver().violation(knots), expected, atol=1e-9)
    knots.layout.turns = False
    assert not TurnsOver().violation(knots).any()
