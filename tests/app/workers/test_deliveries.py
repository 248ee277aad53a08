"""Listeners are called in order, and what one does wrong reaches no other."""

import logging
import threading
import time

from app.workers import deliveries
from app.workers.deliveries import Deliveries


def test_calls_are_made_in_order_and_an_exception_stops_none(caplog):
    made = []
    calls = Deliveries("reports")
    for number in range(100):
        calls.put(lambda number=number: made.append(number))
        calls.put(lambda: 1 / 0)
    calls.close(5.0)
    assert made == list(range(100))
    assert "ZeroDivisionError" in caplog.text


def test_putting_never_waits_and_closing_not_for_ever():
    blocked, calls = threading.Event(), Deliveries("reports")
    calls.put(blocked.wait)
    began = time.monotonic()
    for _ in range(1000):
        calls.put(print)
    calls.close(0.1)
    assert time.monotonic() - began < 1.0
    blocked.set()


def test_a_slow_listener_is_in_the_log(monkeypatch, caplog):
    monkeypatch.setattr(deliveries, "SLOW", 0.01)
    calls = Deliveries("reports")
    with caplog.at_level(logging.WARNING):
        calls.put(lambda: time.sleep(0.02))
        calls.close(5.0)
    assert "reports: a listener took 0.0 s" in caplog.text
