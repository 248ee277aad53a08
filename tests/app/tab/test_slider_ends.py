"""Ends of sliders: whole steps outwards, and never inwards again."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.tab.slider_ends import reaching, stretched
from llsrbm.request.jump import STEPS, Jump
from tests.app.pure_tab import ROBOTS

USUAL = ROBOTS["go2"].task
jumps = st.builds(Jump, **{name: st.floats(-2.0, 2.0) for name in STEPS})


@given(one=jumps, other=jumps)
def test_they_reach_to_all_that_was_asked_for_and_no_step_further(one, other):
    beyond = reaching(reaching({}, USUAL, one), USUAL, other)
    ends = stretched(USUAL, beyond)
    for name, step in STEPS.items():
        low, high = getattr(ends, name)
        usual_low, usual_high = getattr(USUAL, name)
        least, most = (pick(getattr(j, name) for j in (one, other)) for pick in (min, max))
        assert low <= min(usual_low, least) + 1e-5 * step
        assert high >= max(usual_high, most) - 1e-5 * step
        assert low > min(usual_low, least) - step
        assert high < max(usual_high, most) + step


def test_what_is_usual_changes_nothing():
    jump = Jump(forward=USUAL.forward[1], twist=math.pi)
    assert reaching({}, USUAL, jump) == {}
    assert stretched(USUAL, {}) == USUAL


def test_a_longer_end_stays_when_less_is_asked_for():
    beyond = reaching({}, USUAL, Jump(forward=0.7))
    assert beyond == {"forward": (pytest.approx(0.7), pytest.approx(0.7))}
    assert reaching(beyond, USUAL, Jump(forward=0.65)) == beyond
    both = reaching(beyond, USUAL, Jump(forward=-0.5))
    assert stretched(USUAL, both).forward == pytest.approx((-0.5, 0.7))
