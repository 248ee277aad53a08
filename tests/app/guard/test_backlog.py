from __future__ import annotations

import threading
from types import SimpleNamespace

import numpy as np
import pytest
import viser._messages as messages

from app.guard.backlog import queued, weight


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (None, 0),
        (3.0, 0),
        ("abc", 3),
        (b"abcd", 4),
        (np.zeros((10, 3), np.float32), 120),
        (("ab", ["c"], {"x": b"d"}), 4),
        (messages.RunJavascriptMessage("x" * 1000), 1000),
    ],
)
def test_bytes_of_what_a_message_holds(value, expected):
    assert weight(value) == expected


def test_what_holds_itself_ends():
    endless = []
    endless.append(endless)
    assert weight(endless) == 0


def test_a_queue_is_counted():
    waiting = {i: messages.RunJavascriptMessage("x" * i) for i in range(5)}
    queue = SimpleNamespace(message_from_id=waiting, buffer_lock=threading.Lock())
    assert queued(queue) == (5, 10)
    assert queued(None) == (0, 0)
