"""Waiting for what is to come."""

from __future__ import annotations

import time


def wait_until(condition, what, timeout=40.0):
    end = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < end, f"waited in vain for {what}"
        time.sleep(0.02)
