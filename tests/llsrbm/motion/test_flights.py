"""The flights of a rollout, of one jump and of several."""

from dataclasses import replace

import numpy as np
import pytest

from llsrbm.motion.flights import flights, without_contact
from tests.llsrbm.synthetic import TWO_HOPS, TWO_HOPS_DURATIONS, synthetic_plan
from tests.llsrbm.synthetic_rollout import (
    EARLY_TICKS,
    LATENCY_TICKS,
    RATE,
    followed,
    synthetic_rollout,
)

EARLY, LATENCY = EARLY_TICKS / RATE, LATENCY_TICKS / RATE


@pytest.fixture(scope="module")
def hops():
    return followed(synthetic_plan(schedule=TWO_HOPS, durations=TWO_HOPS_DURATIONS))


def test_a_single_flight_is_the_outcomes():
    rollout = synthetic_rollout()
    (flight,) = flights(rollout)
    assert flight.lift_off == pytest.approx(0.5)
    assert flight.touchdown == rollout.outcome.touchdown_true_s
    assert flight.detected == rollout.outcome.touchdown_detected_s
    assert flight.duration == pytest.approx(0.4 - EARLY)


def test_one_that_never_ended():
    rollout = synthetic_rollout()
    lost = replace(
        rollout, outcome=replace(rollout.outcome, touchdown_true_s=None, touchdown_detected_s=None)
    )
    (flight,) = flights(lost)
    assert flight.lift_off == pytest.approx(0.5)
    assert flight.touchdown is flight.detected is flight.duration is None


def test_two_flights(hops):
    first, second = flights(hops)
    assert first.lift_off == pytest.approx(0.6)
    assert first.touchdown == pytest.approx(0.9 - EARLY)
    assert first.detected == pytest.approx(0.9 - EARLY + LATENCY)
    assert second.lift_off == pytest.approx(1.3)
    assert second.touchdown == pytest.approx(1.65 - EARLY)
    assert second.detected == pytest.approx(1.65 - EARLY + LATENCY)
    for flight in (first, second):
        ticks = without_contact(hops, flight)
        assert not hops.contact[ticks].any()
        assert ticks.sum() / RATE == pytest.approx(flight.duration)


def test_a_robot_that_fell_before_its_second_flight(hops):
    ticks = hops.time < 1.1
    arrays = {name: getattr(hops, name)[ticks] for name in ("time", "contact", "phase")}
    (flight,) = flights(replace(hops, **arrays))
    assert flight == flights(hops)[0]
    fallen = hops.time < 0.8
    arrays = {name: getattr(hops, name)[fallen] for name in ("time", "contact", "phase")}
    (flight,) = flights(replace(hops, **arrays))
    assert flight.lift_off == pytest.approx(0.6)
    assert flight.touchdown is flight.detected is None


def test_ticks_with_a_contact_before_the_flight_do_not_end_it(hops):
    """The controller flies by schedule while a foot is still on the ground."""
    contact = hops.contact.copy()
    late = np.flatnonzero(hops.phase == 2)[:3]
    contact[late, 3] = 1
    first, _ = flights(replace(hops, contact=contact))
    assert first.lift_off == pytest.approx(0.6 + 3 / RATE)
    assert first.touchdown == pytest.approx(0.9 - EARLY)
