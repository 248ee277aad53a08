from __future__ import annotations

import threading
import time

import pytest

from app.session.pace import FASTEST, FIRST, SLOWEST, Pace


@pytest.fixture
def pace():
    return Pace(lambda: None, lambda: True)


def test_a_quick_browser_gets_all_frames(pace):
    for _ in range(20):
        pace.learn(0.03)
    assert pace.rate() == FASTEST


def test_a_browser_that_falls_behind_gets_fewer_within_seconds(pace):
    for _ in range(8):
        pace.learn(0.5)
    assert pace.rate() == SLOWEST


def test_between_quick_and_late_nothing_changes(pace):
    pace.learn(0.07)
    assert pace.rate() == FIRST


def test_it_settles_where_a_browser_keeps_up(pace):
    """A browser that draws 20 frames a second answers late as long as it is sent more."""
    rates = []
    for _ in range(100):
        pace.learn(0.3 if pace.rate() > 20 else 0.04)
        rates.append(pace.rate())
    assert 14 < min(rates[20:]) <= max(rates[20:]) < 24


@pytest.mark.parametrize("error", [TimeoutError, RuntimeError])
def test_no_answer_is_survived(error):
    asked = threading.Semaphore(0)

    def ask():
        asked.release()
        raise error

    pace = Pace(ask, lambda: True)
    pace.start()
    for _ in range(2):
        assert asked.acquire(timeout=5)
    pace.close()
    pace._thread.join(5)
    assert not pace._thread.is_alive()


def test_nothing_is_asked_while_paused():
    asked = []
    pace = Pace(lambda: asked.append(1), lambda: False)
    pace.start()
    time.sleep(0.6)
    pace.close()
    assert asked == []
