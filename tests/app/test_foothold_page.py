"""A foot's landing place, dragged with the mouse in the picture and typed in the panel."""

import numpy as np
import pytest

from tests.app.chromium import PACE, PIXELS, at_rest, fill, paused_at, press, status, tab, unfold
from tests.app.waits import wait_until

FOOT = "/footholds/0"  # of the example's robot: its left front foot
STEPS = 5


def square(page, *beside):
    """Pixels of the middle of a foot's handle, and of points (x, y) m beside it."""
    along = 1.7 / 7 * page.session._rendering.footholds._handles[0].scale
    points = [[along + x, along + y, 0] for x, y in ((0, 0), *beside)]
    return page.evaluate(PIXELS, [FOOT, *points])


def stones(page):
    return page.session.state.design.jump.stones


def test_a_foot_is_dragged_typed_and_cleared(page):
    before = page.session.state.design
    paused_at(page, 0.1)
    page.wait_for_function("name => window.__viserMutable.nodeRefFromName[name]", arg=FOOT)
    at_rest(page)  # the camera is where it stays: it follows the robot a moment later
    start, end = square(page, (0.04, 0.03))
    page.mouse.move(*start)
    page.mouse.down()
    for share in np.linspace(0, 1, STEPS + 1)[1:]:
        page.mouse.move(*(np.array(start) + share * np.subtract(end, start)))
        page.wait_for_timeout(PACE)
    page.mouse.up()
    wait_until(lambda: stones(page), "a stone")
    (stone,) = stones(page)
    assert stone.leg == "LF"
    assert (stone.dx, stone.dy) == pytest.approx((0.04, 0.03), abs=2e-3)
    wait_until(lambda: page.session.state.plan.jump.stones == (stone,), "its plan")
    there = square(page)[0]
    assert there == pytest.approx(end, abs=3)

    tab(page, "More")
    unfold(page, "Footholds")
    fill(page, "Ahead [mm]", 20)
    wait_until(lambda: stones(page)[0].dx == 0.02, "what was typed")
    press(page, "Undo")
    wait_until(lambda: stones(page) == (stone,), "what was dragged")
    press(page, "Undo")
    wait_until(lambda: page.session.state.design == before, "the design before")
    press(page, "Redo")
    wait_until(lambda: stones(page) == (stone,), "what was dragged")
    press(page, "Reset footholds")
    wait_until(lambda: page.session.state.design == before, "no stones")
    status(page, "Feasible")
