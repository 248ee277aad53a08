import numpy as np
import pytest

from llsrbm.control.landing import landing_strategy, resolved
from llsrbm.errors import InputError

PLANNED = np.array([[10.0, -5.0, 160.0], [0.0, 0.0, 90.0]])
STANDING = np.array([0.0, 0.0, 75.0])


def test_scaled_forces_brake_in_proportion_to_the_momentum():
    force = landing_strategy("scaled").force
    np.testing.assert_allclose(force(PLANNED, STANDING, 1.0), PLANNED)
    half = force(PLANNED, STANDING, 0.5)
    np.testing.assert_allclose(half - STANDING, (PLANNED - STANDING) / 2)


def test_an_absurd_momentum_is_not_believed():
    force = landing_strategy("scaled").force
    np.testing.assert_allclose(force(PLANNED, STANDING, 9.0), force(PLANNED, STANDING, 1.5))
    np.testing.assert_allclose(force(PLANNED, STANDING, -1.0), force(PLANNED, STANDING, 0.2))


def test_the_papers_landing_takes_the_plans_forces():
    planned = landing_strategy("planned")
    assert planned.follows_forces
    np.testing.assert_array_equal(planned.force(PLANNED, STANDING, 0.3), PLANNED)


def test_auto_is_what_the_robot_file_says():
    assert resolved("auto", 0.2) == "scaled"
    assert resolved("auto", 0.0) == "tracking"
    assert resolved("auto", 0.2, turns=True) == "tracking"
    assert resolved("scaled", 0.2, turns=True) == "scaled"


@pytest.mark.parametrize("name", ["scaled", "planned"])
def test_without_a_force_phase_forces_are_not_followed(name):
    with pytest.raises(InputError) as caught:
        resolved(name, 0.0)
    for word in (name, "control.force_phase = 0", '"auto" or "tracking"'):
        assert word in str(caught.value)
    assert resolved("tracking", 0.0) == "tracking"


def test_unknown_names_are_refused():
    valid = "auto, scaled, planned, tracking"
    with pytest.raises(InputError, match=f'no landing strategy "softly"; valid: {valid}'):
        resolved("softly", 0.2)
