"""Feet on their way: under way they are driven as the planner has it."""

import numpy as np
import pytest

from llsrbm.control.swing import UnderWay, swing_motion
from tests.llsrbm.formats.jumps import planned

FLIGHT = 1


@pytest.fixture(scope="module")
def plan():
    return planned("anymal")


def under_way(plan, change):
    """Times from a knot in flight to touchdown, s, and feet that were slower by `change`, m/s."""
    knot = int(np.argmax(plan.phase == FLIGHT)) + 4
    relative = plan.foot_position - plan.com[:, None]
    mean = (relative[knot + 1] - relative[knot]) / (plan.time[knot + 1] - plan.time[knot])
    start = UnderWay(plan.time[knot], mean - change, np.zeros(len(mean)))
    times = np.linspace(plan.time[knot], plan.touchdown, 400)[:-1]
    (place, velocity, acceleration), _ = swing_motion(plan, times, knot, start)
    return knot, times, place, velocity, acceleration


def test_feet_begin_as_fast_as_they_are_and_end_where_they_land(plan):
    knot, _, place, velocity, _ = under_way(plan, np.array([1.0, 0.0, 0.0]))
    relative = plan.foot_position - plan.com[:, None]
    first = int(np.argmax(plan.phase == FLIGHT + 1))
    np.testing.assert_allclose(place[0], relative[knot], atol=1e-9)
    np.testing.assert_allclose(place[-1], relative[first], atol=5e-3)
    mean = (relative[knot + 1] - relative[knot]) / (plan.time[knot + 1] - plan.time[knot])
    np.testing.assert_allclose(velocity[0], mean - [1.0, 0.0, 0.0], atol=1e-9)


def test_a_change_of_velocity_takes_the_planned_acceleration(plan):
    """From the knot to the interval's middle, as the planner's torques have it."""
    change = np.array([1.0, 0.0, 0.0])
    knot, _, _, _, slow = under_way(plan, change)
    _, _, _, _, unchanged = under_way(plan, np.zeros(3))
    dt = plan.time[knot + 1] - plan.time[knot]
    added, planned = (slow - unchanged)[0], change / (dt / 2)
    np.testing.assert_allclose(added, np.tile(planned, (len(added), 1)), rtol=0.15, atol=1.0)


def test_a_sample_just_before_the_start_is_as_fast_as_it(plan):
    """Times are rounded to samples: a tick without velocities would be a kick."""
    knot, *_ = under_way(plan, np.zeros(3))
    velocity = np.full((plan.foot_position.shape[1], 3), 0.7)
    start = UnderWay(plan.time[knot], velocity, np.zeros(len(velocity)))
    (place, rate, _), _ = swing_motion(plan, plan.time[knot] + np.array([-2e-4, 0.0]), knot, start)
    np.testing.assert_allclose(rate, [velocity, velocity], atol=1e-9)
    np.testing.assert_allclose(place[0], place[1], atol=1e-9)
