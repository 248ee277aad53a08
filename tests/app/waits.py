"""Waiting for what is to come."""

import time


def wait_until(condition, what, timeout=90.0):
    end = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < end, f"waited in vain for {what}"
        time.sleep(0.02)


def eventually(check, *arguments, timeout=20.0):
    """Check until nothing is found wrong, for a layout that is on its way; raises what remains."""
    end = time.monotonic() + timeout
    while True:
        try:
            return check(*arguments)
        except AssertionError:
            if time.monotonic() > end:
                raise
        time.sleep(0.1)
