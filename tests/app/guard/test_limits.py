from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.guard.limits import Rate, TokenBucket


class Clock:
    def __init__(self):
        self.now = 0.0

    def __call__(self):
        return self.now


def test_a_burst_then_the_rate():
    clock = Clock()
    bucket = TokenBucket(Rate(2.0, 3.0), clock)
    assert [bucket.take() for _ in range(4)] == [True, True, True, False]
    clock.now = 0.5
    assert [bucket.take() for _ in range(2)] == [True, False]
    clock.now = 100.0
    assert [bucket.take() for _ in range(4)] == [True, True, True, False]


def test_what_waits_comes_at_the_rate():
    clock = Clock()
    bucket = TokenBucket(Rate(2.0, 3.0), clock)
    assert [bucket.wait() for _ in range(5)] == pytest.approx([0, 0, 0, 0.5, 1.0])


@given(st.lists(st.floats(0, 2), max_size=50))
def test_never_more_than_burst_and_rate_allow(pauses):
    clock = Clock()
    bucket = TokenBucket(Rate(3.0, 4.0), clock)
    taken = 0
    for pause in pauses:
        clock.now += pause
        taken += bucket.take()
        assert taken <= 4 + 3 * clock.now + 1e-6
