"""A route, clicked on the ground of the picture, dragged with the mouse and typed in the panel."""

import numpy as np
import pytest

from llsrbm.request.route import waypoints
from tests.app.chromium import PACE, PIXELS, at_rest, fill, paused_at, press, tab, unfold
from tests.app.waits import wait_until

ORIGIN = ""  # the scene's root: points of the world
STEPS = 5
CLICKS = [(0.4, 0.0), (0.5, 0.4), (0.1, 0.6)]  # m, all of them in sight


def jump(page):
    return page.session.state.design.jump


def places(page):
    return [place[:2] for place in waypoints(jump(page).landings)]


def pixel(page, x, y, z=0.0):
    return page.evaluate(PIXELS, [ORIGIN, [x, y, z]])[0]


def land(page, x, y):
    """Click there until it is a landing: a page takes its time to report clicks."""
    there = pytest.approx((x, y), abs=0.011)

    def landed():
        if places(page)[-1] != there:
            page.mouse.click(*pixel(page, x, y))
            page.wait_for_timeout(10 * PACE)
        return places(page)[-1] == there

    wait_until(landed, "a landing")


def test_a_route_is_clicked_dragged_typed_and_undone(page):
    before = page.session.state.design
    paused_at(page, 0.1)
    unfold(page, "Route")
    assert "No route yet" in page.locator("text=No route yet").inner_text()
    press(page, "Draw route")
    page.wait_for_function("document.querySelector('#llsrbm-remark').textContent")
    for number, place in enumerate(CLICKS, start=1):
        land(page, *place)
        assert jump(page).jumps == number
    press(page, "Stop drawing")
    wait_until(lambda: page.session.state.drawing is None, "the end of it")
    page.mouse.click(*pixel(page, 0.3, -0.5))
    wait_until(lambda: page.session.state.plan.jump == jump(page), "its plan")
    assert len(places(page)) == 3
    assert page.locator("ol[aria-label=Landings] li").all_inner_texts()[0] == "40 cm forward"
    moved = places(page)[1]
    at_rest(page)  # the camera is where it stays
    start, end = pixel(page, *moved), pixel(page, moved[0] + 0.05, moved[1])
    arrow = pixel(page, moved[0] + 0.3, moved[1])
    page.mouse.move(*arrow)
    page.wait_for_timeout(PACE)
    page.mouse.down()
    for share in np.linspace(0, 1, STEPS + 1)[1:]:
        page.mouse.move(*(np.array(arrow) + share * np.subtract(end, start)))
        page.wait_for_timeout(PACE)
    page.mouse.up()
    wait_until(lambda: places(page)[1][0] > moved[0] + 0.02, "the landing that was dragged")
    assert places(page)[2] == pytest.approx(CLICKS[2], abs=0.011)
    tab(page, "More")
    fill(page, "Up [m]", 0.1)
    wait_until(lambda: jump(page).route[2].height == 0.1, "what was typed")
    for before_that, there in (
        (lambda: jump(page).route[2].height == 0.0, "the height before"),
        (lambda: places(page)[1] == moved, "the landing before it was dragged"),
        (lambda: jump(page).jumps == 2, "two landings"),
    ):
        press(page, "Undo")
        wait_until(before_that, there)
    press(page, "Add landing")
    wait_until(lambda: jump(page).jumps == 3, "the landing that was added")
    press(page, "Remove route")
    wait_until(lambda: jump(page).route == (), "no route")
    assert jump(page).forward == pytest.approx(0.4, abs=0.011)
    for _ in range(4):
        press(page, "Undo")
    wait_until(lambda: page.session.state.design == before, "the design before")
