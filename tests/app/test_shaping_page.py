"""Edges and apex of the timeline, dragged with the mouse and moved with the keys, in a browser."""

import pytest

from tests.app.chromium import PACE, paused_at, press
from tests.app.waits import wait_until

# Of the example's plan: it stands for 0.4 s, flies for 0.5 s and stands for 0.4 s.
STEPS = 5


@pytest.fixture
def page(page):
    handle(page, "Apex").wait_for()
    return page


def limits(page):
    return dict(page.session.state.design.tuning.limits)


def middle(page, name):
    ends = [limits(page)[f"{name}_{end}"] for end in ("min", "max")]
    return sum(ends) / 2


def handle(page, name):
    return page.locator(f'#llsrbm-transport [role=slider][aria-label="{name}"]')


def centre(page, name):
    box = handle(page, name).bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def drag(page, name, right=0.0, up=0.0):
    """Grip a handle, and let go of it so many pixels away."""
    x, y = centre(page, name)
    page.mouse.move(x, y)
    page.mouse.down()
    for k in range(1, STEPS + 1):
        page.mouse.move(x + right * k / STEPS, y - up * k / STEPS)
        page.wait_for_timeout(PACE)
    said = handle(page, name).locator("output").inner_text()
    page.mouse.up()
    return said


def per_pixel(page):
    return page.evaluate("llsrbm.timeline.perPixel")


def limited(page, name):
    wait_until(lambda: f"{name}_min" in limits(page), f"limits of {name}")
    wait_until(lambda: not page.session.state.planning, "the plan")


def test_a_dragged_edge_limits_the_phases_beside_it_and_is_undone(page):
    before = page.session.state.design
    pixels = round(0.05 / per_pixel(page))
    said = drag(page, "End of take-off", right=pixels)
    limited(page, "flight")
    moved = pixels * per_pixel(page)
    assert middle(page, "takeoff") == pytest.approx(0.4 + moved, abs=2e-3)
    assert middle(page, "flight") == pytest.approx(0.5 - moved, abs=2e-3)
    assert said == f"End of take-off: {0.4 + moved:.3f} s"
    press(page, "Undo")
    wait_until(lambda: page.session.state.design == before, "the design before")


def test_an_edge_goes_to_an_event_that_is_near(page):
    paused_at(page, 0.45)
    drag(page, "End of take-off", right=round(0.05 / per_pixel(page)) - 4)
    limited(page, "takeoff")
    assert middle(page, "takeoff") == pytest.approx(0.45, abs=6e-4)


def test_the_apex_is_dragged_up_and_let_go_of(page):
    height = float(handle(page, "Apex").get_attribute("aria-valuenow"))
    drag(page, "Apex", up=20)
    limited(page, "apex")
    assert middle(page, "apex") == pytest.approx(height + 0.04, abs=1e-3)
    handle(page, "Apex").dblclick()
    wait_until(lambda: not limits(page), "no limits")


def test_with_the_keys(page):
    """Arrows that follow each other are one step back."""
    before = page.session.state.design
    handle(page, "Loop until").focus()
    names = []
    for _ in range(4):
        page.keyboard.press("Tab")
        names.append(page.evaluate("document.activeElement.getAttribute('aria-label')"))
    assert names == ["End of take-off", "End of flight", "End of landing", "Apex"]
    height = float(handle(page, "Apex").get_attribute("aria-valuenow"))
    for _ in range(3):
        page.keyboard.press("ArrowUp")
    wait_until(lambda: "apex_min" in limits(page), "the apex's limits")
    wait_until(lambda: middle(page, "apex") == pytest.approx(height + 0.015, abs=1e-3), "the last")
    assert handle(page, "Apex").get_attribute("aria-valuetext").endswith(" m above the ground")
    page.keyboard.press("Control+z")
    wait_until(lambda: page.session.state.design == before, "the design before")
    handle(page, "End of flight").focus()
    page.keyboard.press("Shift+ArrowRight")
    wait_until(lambda: "landing_min" in limits(page), "the landing's limits")
    assert middle(page, "flight") == pytest.approx(0.55, abs=1e-3)
    assert middle(page, "landing") == pytest.approx(0.35, abs=1e-3)
    page.keyboard.press("Delete")
    wait_until(lambda: not limits(page), "no limits")


def test_handles_stay_where_the_timeline_is_zoomed_and_texts_can_be_read(page):
    page.evaluate("llsrbm.player.setRange([0.3, 0.7])")
    press(page, "Zoom")
    assert handle(page, "End of take-off").is_visible()
    assert not handle(page, "End of flight").is_visible()
    press(page, "Zoom")
    size = "element => parseFloat(getComputedStyle(element).fontSize)"
    assert handle(page, "Apex").locator("output").evaluate(size) >= 12
