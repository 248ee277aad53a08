"""Ground or push, by synthetic impulses; whole robots are pushed in tests of pushes."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from llsrbm.control.felt_impulse import FeltImpulse

MASS, TICK, G = 30.0, 0.0025, np.array([0.0, 0.0, -9.81])


def flown(felt, force, by_feet, ticks, velocity):
    """Fall for some ticks under a force, a share of which passes through the feet."""
    for _ in range(ticks):
        velocity = velocity + (G + force / MASS) * TICK
        felt.update(velocity, by_feet * force)
    return velocity


vectors = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array).filter(lambda v: np.linalg.norm(v) > 0.1)


@given(vectors, st.integers(1, 8), st.floats(0.5, 1.2))
def test_what_passes_through_the_feet_is_the_ground(direction, ticks, by_feet):
    felt = FeltImpulse(MASS, TICK)
    v = flown(felt, np.zeros(3), 0.0, 10, np.zeros(3))
    flown(felt, 400 * direction, by_feet, ticks, v)
    assert felt.is_ground()
    assert not felt.pushed


@given(vectors, st.integers(1, 8), st.floats(-0.1, 0.1))
def test_what_does_not_is_a_push(direction, ticks, by_feet):
    felt = FeltImpulse(MASS, TICK)
    v = flown(felt, np.zeros(3), 0.0, 10, np.zeros(3))
    flown(felt, 400 * direction, by_feet, ticks, v)
    assert not felt.is_ground()
    assert felt.pushed


def test_noise_after_a_push_is_not_the_ground_and_the_ground_still_is():
    felt = FeltImpulse(MASS, TICK)
    v = flown(felt, np.array([800.0, 0.0, 0.0]), 0.0, 8, np.zeros(3))
    assert not felt.is_ground()
    v = flown(felt, np.array([0.1, 0.0, 2.0]), 1.0, 10, v)
    assert not felt.is_ground()
    flown(felt, np.array([0.0, 0.0, 500.0]), 1.0, 2, v)
    assert felt.is_ground()
    felt.reset()
    assert not felt.pushed


def test_a_flight_that_has_just_begun_trusts_the_detector():
    felt = FeltImpulse(MASS, TICK)
    assert felt.is_ground()
    felt.update(np.zeros(3), np.zeros(3))
    assert felt.is_ground()
