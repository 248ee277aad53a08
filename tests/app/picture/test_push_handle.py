from __future__ import annotations

import contextlib
import math
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.picture.push_handle import PushHandle, PushShown
from tests.app.picture.recorded import RecordedClient

SHOWN = PushShown(0.5, (0.1, 0.2, 0.6), (0.0, 10.0, 2.0), 0.05)
GRIP, ARROW, SIZE = "/push/tip", "/push/arrow", "/push/size"


class Target:
    def __init__(self):
        self.grips = []
        client = RecordedClient()
        self.nodes = client.scene.nodes
        self.handle = PushHandle(client, self.grips.append)

    @property
    def seen(self):
        return {name for name, node in self.nodes.items() if node.visible}

    def drag(self, position, phase="update"):
        self.nodes[GRIP].position = position
        with contextlib.suppress(StopIteration):  # it waits for nothing
            self.nodes[GRIP].callback(SimpleNamespace(phase=phase)).send(None)


@pytest.fixture
def target():
    made = Target()
    made.handle.draw(SHOWN)
    return made


def test_the_grip_is_at_the_tip_and_the_size_beside_it(target):
    assert target.nodes[GRIP].position == pytest.approx((0.1, 0.7, 0.7))
    assert target.nodes[SIZE].text == "10.2 N s"
    begin, end = target.nodes[ARROW].points[0]
    assert begin == pytest.approx(SHOWN.origin)
    assert end == pytest.approx(SHOWN.tip)
    assert target.seen == {GRIP, ARROW, SIZE}


def test_without_a_size_there_is_a_grip_alone(target):
    target.handle.draw(PushShown(0.5, (0.0, 0.0, 0.5), (0.0, 0.0, 0.0), 0.05))
    assert target.seen == {GRIP, SIZE}
    assert target.nodes[SIZE].text == "drag to push"


def test_a_drag_is_an_impulse_and_leaves_the_vertical(target):
    target.drag((0.6, 0.2, 5.0))
    target.drag((0.6, 0.3, 5.0), "end")
    first, last = target.grips
    assert first.impulse == pytest.approx((10.0, 0.0, 2.0))
    assert (first.ended, last.ended) == (False, True)
    assert last.impulse == pytest.approx((10.0, 2.0, 2.0))
    assert first.time == last.time == 0.5


def test_what_is_drawn_meanwhile_does_not_take_it_out_of_the_hand(target):
    target.drag((0.6, 0.2, 0.7), "start")
    target.handle.draw(PushShown(0.5, SHOWN.origin, (9.9, 0.0, 2.0), 0.05))
    assert target.nodes[GRIP].position == (0.6, 0.2, 0.7)
    target.drag((0.6, 0.2, 0.7), "end")
    target.handle.draw(PushShown(0.5, SHOWN.origin, (9.9, 0.0, 2.0), 0.05))
    assert target.nodes[GRIP].position == pytest.approx((0.595, 0.2, 0.7))


def test_a_drag_that_began_at_one_instant_belongs_to_it(target):
    target.drag((0.6, 0.2, 0.7), "start")
    target.handle.draw(PushShown(0.9, (5.0, 5.0, 0.6), (0.0, 0.0, 0.0), 0.05))
    target.drag((0.6, 0.2, 0.7), "end")
    assert target.grips[-1].time == 0.5
    assert target.grips[-1].impulse == pytest.approx((10.0, 0.0, 2.0))


@pytest.mark.parametrize("nonsense", ["here", None, [], [1.0, 0.0], [math.nan, 0, 0], {}])
def test_what_is_no_place_changes_nothing(target, nonsense):
    target.drag(nonsense)
    assert target.grips == []


@given(st.floats(-100, 100), st.floats(-100, 100), st.floats(0.01, 1.0))
def test_the_impulse_to_its_own_tip_is_the_impulse(x, y, scale):
    shown = PushShown(0.3, (0.2, -0.4, 0.5), (x, y, 1.0), scale)
    assert shown.impulse_to(shown.tip) == pytest.approx((x, y, 1.0), abs=1e-9)


def test_nobody_drags_what_is_not_there():
    target = Target()
    target.drag((1.0, 1.0, 1.0))
    assert target.grips == []


def test_nothing_is_shown_of_no_push(target):
    target.handle.draw(None)
    assert target.seen == set()
