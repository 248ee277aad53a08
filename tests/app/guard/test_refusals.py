import logging
import sys
from dataclasses import replace

import pytest

from app.guard.limits import Limits
from app.guard.refusals import Refusals
from tests.app.guard.clock import Clock


@pytest.fixture
def clock():
    return Clock(0.0)


@pytest.fixture
def refusals(clock):
    return Refusals(Limits(), clock)


@pytest.fixture(autouse=True)
def lines(caplog):
    with caplog.at_level(logging.WARNING):
        yield lambda: [record.getMessage() for record in caplog.records]


def test_ten_thousand_refusals_are_one_line_and_a_summary(refusals, clock, lines):
    for _ in range(10_000):
        refusals.note("10.0.0.1", "unknown host", "evil.example")
    assert lines() == ["refused 10.0.0.1: unknown host (evil.example)"]
    clock.now = 60.0
    refusals.note("10.0.0.1", "unknown host", "evil.example")
    assert lines()[1:] == ["refused 10000 more since: 10000 x 10.0.0.1: unknown host"]
    refusals.summarise()
    assert len(lines()) == 2


def test_ten_thousand_peers_are_no_flood_either(refusals, clock, lines):
    for i in range(10_000):
        refusals.note(f"10.{i >> 8}.{i & 255}.1", f"reason {i}")
        clock.now += 0.001
    assert len(lines()) <= 25
    refusals.summarise()
    assert len(lines()[-1]) < 1000
    assert "x others" in lines()[-1]


def test_memory_is_bounded(clock):
    refusals = Refusals(replace(Limits(), refusals=50, first_lines=10_000), clock)
    for i in range(5_000):
        for _ in range(2):
            refusals.note(f"peer {i}", "reason")
    assert len(refusals._known) <= 50
    assert len(refusals._since) <= 51
    assert sys.getsizeof(refusals._since) < 10_000


def test_a_line_stays_a_line(refusals, lines):
    refusals.note("10.0.0.1", "unknown host", "a\nWARNING forged\x1b[2J" + "x" * 5000)
    (line,) = lines()
    assert "\n" not in line
    assert "\x1b" not in line
    assert len(line) < 200


def test_the_servers_own_check_is_not_logged(refusals, lines):
    with refusals.unlogged():
        assert refusals.note("127.0.0.1", "unknown host") is False
    assert lines() == []
    assert refusals.note("127.0.0.1", "unknown host") is True
