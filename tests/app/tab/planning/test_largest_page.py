"""How far? in a real browser: found by the keys, told, cancelled, taken."""

import math
import re

from tests.app.chromium import fill, number, press, settled, status
from tests.app.legibility import unreadable
from tests.app.planners import SLOW, STOPS_MORE
from tests.app.shared_page import visit
from tests.app.waits import wait_until

SLIDERS = {
    "Twist": "Twist [deg]",
    "Forward": "Forward [m]",
    "Lateral": "Lateral [m]",
    "Landing height": "Landing height [m]",
}
SIZES = [(1440, 900), (1280, 720), (390, 844)]


def button(page, name):
    return page.get_by_role("button", name=f"How far? {name}", exact=True)


def boxes(page):
    """Of each slider the places of its button, its number, its label and its thumb."""
    for name, label in SLIDERS.items():
        parts = button(page, name), number(page, label), page.get_by_text(label, exact=True)
        thumb = page.get_by_role("slider", name=label, exact=True)
        yield name, [part.bounding_box() for part in (*parts, thumb)]


def apart(one, other):
    return (
        one["x"] + one["width"] <= other["x"]
        or other["x"] + other["width"] <= one["x"]
        or one["y"] + one["height"] <= other["y"]
        or other["y"] + other["height"] <= one["y"]
    )


def test_a_press_leads_to_the_largest_jump_which_is_taken(browser, designer):
    page = visit(browser, designer)
    session, sentence = page.session, page.locator(".llsrbm-far")
    button(page, "Forward").focus()
    page.keyboard.press("Enter")
    found = f"Forward: 0.70 m is the largest found; what stops it: {STOPS_MORE}."
    sentence.filter(has_text=found).wait_for()
    wait_until(lambda: session.state.ends.forward[1] == 0.7, "a longer slider")
    page.get_by_text("0.7", exact=True).first.wait_for()  # its end
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        settled(page)
        assert unreadable(page) == []
        for name, (own, *others) in boxes(page):
            assert all(apart(own, other) for other in others), (name, width)
    page.set_viewport_size({"width": 1280, "height": 800})
    press(page, "Use largest")
    wait_until(lambda: float(number(page, "Forward [m]").input_value()) == 0.7, "the slider")
    status(page, "Feasible")
    assert session.state.plan is session.state.far.found.plan
    assert page.get_by_role("button", name="Use largest").count() == 0
    fill(page, "Lateral [m]", 0.1)
    sentence.filter(has_text=re.compile("^Of the request before")).wait_for()
    assert not page.faults
    page.context.close()


def test_a_search_says_how_far_it_has_come_and_is_cancelled(browser, designer):
    page = visit(browser, designer)
    fill(page, "Twist [deg]", round(math.degrees(SLOW)))
    plan = lambda: page.session.state.plan  # noqa: E731
    wait_until(lambda: math.isclose(plan().jump.twist, SLOW) and plan().refined, "its plan")
    status(page, "Feasible")
    press(page, "How far? Landing height")
    sentence = page.locator(".llsrbm-far")
    sentence.filter(has_text="Up: 0.65 m holds, trying 0.70 m ...").wait_for()
    press(page, "Cancel")
    sentence.wait_for(state="detached")
    assert page.get_by_role("button", name="Cancel").count() == 0
    status(page, "Feasible")
    assert not page.faults
    page.context.close()
