import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from llsrbm.motion.plan import Phase
from llsrbm.planning.layout import Intervals, Layout, Role

LAYOUT = Layout(legs=4, contacts=4, intervals=Intervals(3, 4, 5))


@given(total=st.integers(9, 300))
def test_intervals_are_shared_evenly(total):
    split = Intervals.split(total)
    parts = split.takeoff, split.flight, split.landing
    assert sum(parts) == split.total == total
    assert max(parts) - min(parts) <= 2


def test_every_scalar_has_one_place():
    taken = np.zeros(LAYOUT.size_total, dtype=int)
    for k, role in enumerate(LAYOUT.roles):
        places = LAYOUT.variables(k)
        assert tuple(places) == (*LAYOUT.states(role), *LAYOUT.controls(role))
        for name, place in places.items():
            assert place.stop - place.start == LAYOUT.size(name)
            taken[place] += 1
        states = sum(LAYOUT.size(name) for name in LAYOUT.states(role))
        assert states == LAYOUT.state_size(role)
    assert (taken == 1).all()


def test_only_what_a_phase_needs_is_a_variable():
    for role in LAYOUT.roles:
        names = (*LAYOUT.states(role), *LAYOUT.controls(role))
        assert ("force" in names) == role.in_contact
        assert ("feet_step" in names) == (role.phase == Phase.FLIGHT)
        assert ("feet_stop" in names) == (role.phase == Phase.FLIGHT and role.last)
        assert ("rotation_rate" in names) != role.terminal
    assert "position" not in LAYOUT.variables(0)
    assert LAYOUT.states(LAYOUT.roles[-1]) == ("position", "quat", "velocity", "momentum")


def test_blocks_are_runs_of_one_role():
    covered = []
    for role, knots in LAYOUT.blocks():
        assert all(LAYOUT.roles[k] == role for k in knots)
        covered += knots
    assert covered == list(range(LAYOUT.knots))
    assert LAYOUT.knots == 13


def test_progress_restarts_with_each_phase():
    thirds, quarters, fifths = np.arange(3) / 3, np.arange(4) / 4, np.arange(5) / 5
    np.testing.assert_allclose(LAYOUT.progress, [*thirds, *quarters, *fifths, 1.0])


@pytest.mark.parametrize(
    ("role", "name"),
    [
        (Role(Phase.TAKEOFF, first=True), "takeoff_first"),
        (Role(Phase.FLIGHT), "flight"),
        (Role(Phase.LANDING, terminal=True), "landing_terminal"),
    ],
)
def test_roles_describe_themselves(role, name):
    assert role.describe() == name
