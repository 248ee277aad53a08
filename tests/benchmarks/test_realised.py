"""What the plans of each model are worth on the whole robot."""

import numpy as np
import pytest

from benchmarks.realised import realise
from llsrbm import models
from llsrbm.planning.answer.planner import planner_of
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.llsrbm.planning.solved import FLIPS, TYPES, solved

ROBOT = load_robot("anymal")


@pytest.fixture(scope="module")
def twists():
    return {name: realise(solved(name, "twist").knots) for name in models.MODELS}


@pytest.mark.parametrize("request_name", ["twist", "all"])
def test_plans_of_llsrbm_plus_are_true(request_name):
    """Figures of the benchmark: Izz 1 %, Lz 2.6 % RMS and 3.6 % at worst on the 90 degree twist."""
    found = realise(solved("llsrbm-plus", request_name).knots)
    error = (found.momenta_true - found.momenta_plan)[found.flight, 2]
    assert found.inertia_errors[2] < 0.02
    assert found.momentum_errors[2] < 0.04
    assert np.abs(error).max() < 0.05 * np.abs(found.momenta_plan[:, 2]).max()


def test_those_of_the_simpler_models_are_not(twists):
    """What the paper leaves out shows: the legs' momentum, and knees that go outward."""
    plus = twists["llsrbm-plus"]
    for name in ("srbm", "llsrbm"):
        assert twists[name].momentum_errors[2] > 2 * plus.momentum_errors[2]
        assert twists[name].inertia_errors[2] > 2 * plus.inertia_errors[2]


@pytest.mark.nightly
def test_turning_jumps_of_any_type_are_true_in_flight():
    """Every diagonal inertia within 5 %, every component of L within 5 % of its peak."""
    jump = Jump(**TYPES["hops"] | {"twist": np.pi / 4})
    planner = planner_of(jump)
    planner.plan(jump, patient=False)
    turning = realise(planner.last_knots())
    assert turning.inertia_errors.max() < 0.05
    assert turning.momentum_errors.max() < 0.05


@pytest.mark.nightly
@pytest.mark.parametrize("name", FLIPS)
def test_flips_are_true_in_flight(name):
    """The plan is made with a model that the whole body has corrected."""
    s = solved("llsrbm-plus", name, "go2")
    found = realise(s.knots)
    assert found.inertia_errors[1] < 0.05
    # Legs that tuck far are at the edge of their maps, and most of the inertia about the roll axis.
    assert found.inertia_errors.max() < (0.06 if name == "flip" else 0.2)
    assert found.momentum_errors.max() < 0.05
    assert np.degrees(np.abs(found.turn_error)).max() < 1.0


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["rear-last", "run-up"])
def test_straight_jumps_of_any_type_hardly_turn_otherwise_than_planned(name):
    """Without a turn L is the little that legs and trunk, 0.4 each, leave of each other.

    What the maps leave out, up to 0.09 kg m2/s about the lateral axis, is as much as 40 % of that;
    over the flight it cancels.
    """
    knots = solved("llsrbm-plus", name).knots
    found = realise(knots)
    assert found.flight.sum() == sum(flight.stop - flight.start for flight in knots.flights)
    assert found.inertia_errors.max() < 0.05
    error = (found.momenta_true - found.momenta_plan)[found.flight]
    assert np.sqrt(np.mean(error**2, axis=0)).max() < 0.12
    assert np.degrees(np.abs(found.turn_error)).max() < 0.5
    assert found.foot_residual.max() < 1e-5


def test_what_the_maps_leave_out_hardly_turns_a_biped():
    """The pelvis is a fifth of the legs: a degree of leg swing turns it by five.

    Here it is 0.9 degrees, of which the soles' own tilt 0.8; the paper's model 9.6.
    """
    knots = solved("llsrbm-plus", "twist", "slider").knots
    found = realise(knots)
    assert np.degrees(np.abs(found.turn_error)).max() < 1.5
    assert found.foot_residual.max() < 1e-5
    assert (np.abs(found.joint_speed) <= load_robot("slider").speed_limit).all()
    flight = found.flight
    np.testing.assert_allclose(found.interval[flight].sum(), knots.durations[1])


def test_the_turn_error_is_what_integrating_the_rest_gives(twists):
    """About z, where the base hardly tilts: momentum missing over inertia, summed over flight."""
    found = twists["llsrbm"]
    missing = (found.momenta_plan - found.momenta_true)[:, 2] / found.inertias_true[:, 2]
    turned = (missing * found.interval)[found.flight].sum()
    assert found.turn_error[2] == pytest.approx(turned, rel=0.05)
    assert abs(found.turn_error[2]) > np.radians(2)
