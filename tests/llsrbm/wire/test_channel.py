"""Messages that take their time, come late, or not at all."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from llsrbm.errors import InputError
from llsrbm.wire.channel import Channel, Faults

PERIOD = 0.002


def arrivals(channel, count, fine=1e-4):
    """(n,) number and s of arrival of each message that arrives, of one each period."""
    seen = []
    for k in range(count):
        channel.send(k * PERIOD, k)
        for step in range(round(PERIOD / fine)):
            now = k * PERIOD + step * fine
            seen += [(number, now) for number in channel.arrived(now)]
    return np.array(seen)


def test_messages_take_between_the_least_and_the_most():
    seen = arrivals(Channel(0.002, 0.001, Faults(), np.random.default_rng(1)), 500)
    took = seen[:, 1] - seen[:, 0] * PERIOD
    assert len(seen) >= 498
    assert took.min() >= 0.001
    assert took.max() <= 0.003 + 1e-4
    assert took.mean() == pytest.approx(0.002, abs=1e-4)
    assert np.std(took) == pytest.approx(0.001 / np.sqrt(3), rel=0.1)


def test_a_share_is_lost_and_never_arrives():
    seen = arrivals(Channel(0.0, 0.0, Faults(lost=0.2), np.random.default_rng(2)), 2000)
    assert len(seen) / 2000 == pytest.approx(0.8, abs=0.03)
    assert not arrivals(Channel(0.0, 0.0, Faults(lost=1.0), np.random.default_rng(2)), 20).size


def test_a_late_message_holds_up_those_behind_it():
    seen = arrivals(Channel(0.0, 0.0, Faults(late=0.02), np.random.default_rng(3)), 2000)
    took = seen[:, 1] - seen[:, 0] * PERIOD
    late = took >= 0.02 - 1e-9
    assert 10 < late.sum() < 80
    first = int(np.flatnonzero(late)[0])
    behind = took[first : first + 10]  # all at the same moment
    assert behind == pytest.approx(0.02 - PERIOD * np.arange(10), abs=2e-4)


@given(st.floats(0, 0.01), st.floats(0, 0.01), st.floats(0, 1), st.floats(0, 1), st.integers(0, 99))
def test_messages_keep_their_order_and_come_once(delay, spread, lost, late, seed):
    channel = Channel(delay, spread, Faults(lost, late), np.random.default_rng(seed))
    seen = arrivals(channel, 20, fine=1e-3)
    numbers = seen[:, 0] if seen.size else np.zeros(0)
    assert (np.diff(numbers) > 0).all()


def test_the_same_messages_are_lost_whatever_the_delay():
    quick = arrivals(Channel(0.0, 0.0, Faults(lost=0.3), np.random.default_rng(5)), 100)
    slow = arrivals(Channel(0.001, 0.0, Faults(lost=0.3), np.random.default_rng(5)), 100)
    np.testing.assert_array_equal(quick[:, 0], slow[:, 0])


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ({"lost": 1.2}, "lost: expected a share of 0 to 1, got 1.2"),
        ({"late": -0.1}, "late: expected a share of 0 to 1, got -0.1"),
        ({"late_by": 11}, "late_by: expected 0 to 10 s, got 11"),
    ],
)
def test_faults_out_of_range(fault, message):
    with pytest.raises(InputError, match=message):
        Faults(**fault)
