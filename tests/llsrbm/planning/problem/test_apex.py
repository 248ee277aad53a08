"""Flights in closed form, against falls that are followed step by step."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from llsrbm.mechanics import GRAVITY
from llsrbm.planning.problem.apex import Flight, limits_apex

HEIGHTS, TIMES = st.floats(0.2, 1.0), st.floats(0.1, 1.0)


def falls(flight):
    """Heights at instants of a flight, m, and these, s."""
    t = np.linspace(0, flight.time, 4001)
    speed = (flight.after - flight.before) / flight.time + GRAVITY * flight.time / 2
    return flight.before + speed * t - GRAVITY * t**2 / 2, t


@given(before=HEIGHTS, after=HEIGHTS, time=TIMES)
def test_the_apex_is_the_highest_place(before, after, time):
    flight = Flight(before, after, time)
    z, t = falls(flight)
    assert flight.apex == pytest.approx(z.max(), abs=1e-6)
    assert flight.rising == pytest.approx(t[z.argmax()], abs=1e-3)
    assert z[-1] == pytest.approx(after)


@given(before=HEIGHTS, after=HEIGHTS, rise=st.floats(0.01, 0.5))
def test_a_flight_takes_as_long_as_its_apex_asks(before, after, rise):
    apex = max(before, after) + rise
    flight = Flight(before, after, Flight(before, after, 1.0).time_to(apex))
    assert flight.apex == pytest.approx(apex)


def test_limits_of_other_things_are_none_of_the_apex():
    assert limits_apex({"apex_max": 0.6, "friction": 0.5})
    assert not limits_apex({"flight_min": 0.4})
    assert not limits_apex(None)
