"""The picture is asked what a part does, and the trunk is pulled; in a real browser."""

import numpy as np
import pytest

from llsrbm.request.design import Design
from tests.app.chromium import PACE, PIXELS, at_rest, paused_at
from tests.app.waits import wait_until

BOX = "#llsrbm-part"
FOOT = "LF foot"


@pytest.fixture
def page(page):
    """In mid-flight."""
    paused_at(page, 0.5)
    at_rest(page)  # parts are where they stay
    yield page
    page.keyboard.press("Escape")
    page.mouse.move(10, 10)
    page.session._inbox.put(Design(page.session.state.design.jump))
    wait_until(lambda: not page.session.state.design.scenario.pushes, "no push")


def place(page, part):
    """Pixels of the middle of a part."""
    found = page.evaluate(f"llsrbm.player.clip.parts.find(({{name}}) => name === '{part}')")
    return np.mean(page.evaluate(PIXELS, [found["node"], *found["ends"]]), axis=0)


def test_a_part_under_the_pointer_says_what_it_does(page):
    page.mouse.move(*place(page, FOOT))
    page.locator(BOX).get_by_text(FOOT).wait_for()
    rows = page.locator(BOX).locator("tr")
    assert rows.count() == 4
    assert rows.first.inner_text().split()[:2] == ["Force", "x"]
    page.mouse.move(30, 300)
    page.wait_for_function(f"document.querySelector('{BOX}').style.display === 'none'")


def test_a_part_that_comes_under_a_resting_pointer_does_so_too(page):
    foot = place(page, FOOT)
    paused_at(page, 0.0)
    at_rest(page)
    assert np.linalg.norm(place(page, FOOT) - foot) > 30, "the foot has moved away"
    page.mouse.move(*foot)
    paused_at(page, 0.5)
    page.locator(BOX).get_by_text(FOOT).wait_for()


def test_a_click_keeps_it_and_a_row_becomes_a_chart(page):
    page.mouse.move(*place(page, "LF_KFE"))
    page.mouse.click(*place(page, "LF_KFE"))
    button = page.get_by_role("button", name="Add Torque of LF_KFE to the plots")
    page.mouse.move(30, 300)
    before = page.session.state.plots.charts
    button.click()
    wait_until(lambda: len(page.session.state.plots.charts) > len(before), "the chart")
    assert page.session.state.plots.charts[-1].components == ("LF_KFE",)
    page.keyboard.press("Escape")
    assert not button.is_visible()


def test_the_trunk_is_pulled_with_ctrl_and_that_is_a_push(page):
    x, y = place(page, "trunk")
    camera = "window.__viserMutable.cameraControl.getPosition().toArray()"
    page.keyboard.down("Control")
    page.mouse.move(x, y)
    page.mouse.down()
    before = page.evaluate(camera)
    for share in (0.3, 0.7, 1.0):
        page.mouse.move(x + 90 * share, y)
        page.wait_for_timeout(PACE)
    # It is not the camera that is turned.
    assert page.evaluate(camera) == pytest.approx(before, abs=1e-3)
    page.mouse.up()
    page.keyboard.up("Control")
    wait_until(lambda: page.session.state.rollout is not None, "the simulation")
    (push,) = page.session.state.rollout.scenario.pushes
    assert push.time == pytest.approx(0.5, abs=0.01)
    assert np.linalg.norm(push.impulse) > 1
    # To the right in the picture, which is towards +x +y there, level.
    assert push.impulse[0] + push.impulse[1] > 0
    assert push.impulse[2] == 0
