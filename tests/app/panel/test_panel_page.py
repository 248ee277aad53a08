"""The panel in a real browser: one page for all, at the size of a small screen."""

import re

import pytest

from app.motion import colours
from tests.app.chromium import fill, number, status, tab, unfold
from tests.app.shared_page import visit
from tests.app.waits import wait_until

TABS = ("View", "Results", "Plots", "Files", "More")
HEAD = ("Share", "Open", "Undo", "Redo", "Robot", "Jump type")
BELOW = ("Model", "Simulate", "Scenario", "Format", "Export", "Details")
SLIDERS = ("Twist [deg]", "Forward [m]", "Lateral [m]", "Landing height [m]")


@pytest.fixture(scope="module")
def page(browser, designer):
    """Of a first visit: the tour is offered."""
    page = visit(browser, designer, tour=True)
    yield page
    assert page.faults == []
    page.context.close()


def box(page, label):
    """Where a control is, by the name that assistive software has of it."""
    button = page.get_by_role("button", name=label, exact=True)
    found = button if button.count() else page.get_by_label(label, exact=True)
    return found.bounding_box()


def test_the_tour_is_offered_once_the_robot_moves(page):
    welcome = page.get_by_role("dialog", name="Design a jump; see why inertia matters")
    welcome.wait_for()
    welcome.locator(".example button").wait_for()
    page.get_by_role("button", name="Tour", exact=True).click()
    card = page.get_by_role("dialog", name="Move a slider")
    card.wait_for()
    assert "1 of 4" in card.inner_text()
    assert card.get_by_role("button").all_inner_texts() == ["Skip", "Next"]
    headings = []
    for button in ("Next", "Next", "Next", "Done"):
        headings.append(page.locator("#llsrbm-tour h2").inner_text())
        pointed = page.locator(".llsrbm-pointed").count()
        assert pointed == (0 if headings[-1] == "Read the ellipsoid" else 1)
        page.get_by_role("button", name=button, exact=True).click()
    assert headings == ["Move a slider", "Read the ellipsoid", "Simulate", "Take it along"]
    assert not page.locator("#llsrbm-tour").is_visible()
    assert page.evaluate("localStorage.getItem('llsrbm.tour')") == "seen"
    page.evaluate("llsrbm.tour.offer()")
    assert not page.locator("#llsrbm-tour").is_visible()


def test_the_help_starts_the_tour_and_escape_ends_it(page):
    page.get_by_role("button", name="Help", exact=True).click()
    words = page.get_by_role("dialog", name="Help")
    words.get_by_text("Models", exact=True).click()
    assert words.get_by_text("one rigid body, constant inertia").is_visible()
    for term in ("Twist [deg]", "Yaw inertia Izz, flight", "Compare models", "Estimator"):
        assert words.get_by_role("term").filter(has_text=term).count() == 1
    words.get_by_role("button", name="Start the tour").click()
    page.get_by_role("dialog", name="Move a slider").wait_for()
    page.keyboard.press("Escape")
    assert not page.locator("#llsrbm-tour").is_visible()


def test_what_a_first_jump_needs_is_in_sight_without_scrolling_in_the_order_of_its_use(page):
    places = {label: box(page, label) for label in (*HEAD, *SLIDERS, *BELOW)}
    assert sorted(places.values(), key=lambda place: place["y"]) == list(places.values())
    for label, place in places.items():
        assert place["y"] >= 0, label
        assert place["y"] + place["height"] <= page.viewport_size["height"], label
    verdict = page.get_by_role("status").bounding_box()
    assert places["Landing height [m]"]["y"] < verdict["y"] < places["Model"]["y"]


def test_the_details_are_tabs_in_one_row(page):
    tab(page, "View")
    page.get_by_label("Inertia ellipsoids").wait_for()
    tabs = [page.get_by_role("tab", name=name).first.bounding_box() for name in TABS]
    assert len({tab["y"] for tab in tabs}) == 1
    assert tabs[-1]["x"] + tabs[-1]["width"] <= page.viewport_size["width"]


def test_the_panel_is_one_scroll(page):
    unfold(page, "Limits")
    page.get_by_label("friction", exact=True).wait_for()
    panel = page.locator("[data-scrollarea-viewport]").filter(has=page.get_by_role("status"))
    assert panel.evaluate("each => each.scrollHeight > each.clientHeight")
    assert panel.evaluate("each => each.scrollWidth === each.clientWidth")
    inner = """each => [...each.querySelectorAll("*")].filter(inside =>
      /auto|scroll/.test(getComputedStyle(inside).overflowY)
      && inside.scrollHeight > inside.clientHeight + 1).map(inside => inside.className)"""
    assert panel.evaluate(inner) == []
    tab(page, "View")
    unfold(page, "Details")


def test_a_folder_is_a_button_of_the_keyboard(page):
    title = page.get_by_role("button", name="Scenario", exact=True)
    for key, expanded in (("Enter", "true"), ("Space", "false")):
        title.press(key)
        wait_until(lambda e=expanded: title.get_attribute("aria-expanded") == e, expanded)


def test_a_box_shows_the_colours_of_its_overlay_and_is_grey_while_it_shows_nothing(page):
    look = """each => [getComputedStyle(each).color,
      getComputedStyle(each, "::before").backgroundImage]"""
    unfold(page, "More overlays")
    ellipsoids, pushes = (
        page.locator("label").filter(has_text=re.compile(f"^{name}$")).first.evaluate(look)
        for name in ("Inertia ellipsoids", "Pushes")
    )
    planned, reference = (
        f"rgb({', '.join(map(str, colour))})" for colour in (colours.PLANNED, colours.REFERENCE)
    )
    assert planned in ellipsoids[1]
    assert reference in ellipsoids[1]
    assert pushes[1] == "none"
    assert pushes[0] != ellipsoids[0]


def test_labels_are_one_line_and_one_button_is_filled(page):
    heights = page.evaluate(
        """() => [...document.querySelectorAll("label")].filter(each => each.offsetParent)
          .map(each => [each.textContent, each.getClientRects().length])"""
    )
    assert len(heights) > 15
    assert [text for text, lines in heights if lines != 1] == []
    filled = page.evaluate(
        """() => [...document.querySelectorAll("button.mantine-Button-root")]
          .filter(each => each.offsetParent)
          .filter(each => getComputedStyle(each).color === "rgb(255, 255, 255)")
          .map(each => each.textContent)"""
    )
    assert filled == ["Simulate"]


def test_every_slider_has_a_name_for_both_ways_to_set_it(page):
    for label in SLIDERS:
        assert page.get_by_role("slider", name=label, exact=True).count() == 1
        assert page.get_by_label(label, exact=True).get_attribute("inputmode") == "decimal"


def test_nothing_below_moves_when_a_simulation_runs(page, designer):
    page.get_by_role("button", name="Details", exact=True).click()  # folded, as it begins
    places = {label: box(page, label) for label in ("Format", "Export", "Open")}
    page.get_by_role("button", name="Simulate", exact=True).click()
    page.get_by_role("button", name="Cancel").or_(
        page.get_by_role("status").filter(has_text="Landed")
    ).first.wait_for()
    assert {label: box(page, label) for label in places} == places
    status(page, "Landed")
    assert {label: box(page, label) for label in places} == places
    assert page.get_by_role("button", name="Cancel").count() == 0


def test_what_cannot_be_undone_is_not_offered(page):
    undo, redo = (page.get_by_role("button", name=name) for name in ("Undo", "Redo"))
    assert undo.is_disabled()
    assert redo.is_disabled()
    fill(page, "Forward [m]", 0.3)
    wait_until(undo.is_enabled, "an undo")
    undo.click()
    wait_until(lambda: float(number(page, "Forward [m]").input_value()) == 0, "the one before")
    wait_until(redo.is_enabled, "a redo")


def test_a_limit_is_changed_marked_and_put_back(page):
    tuning = lambda: dict(page.session.state.design.tuning.limits)  # noqa: E731
    unfold(page, "Limits")
    friction = page.get_by_label("friction", exact=True)
    friction.fill("0.4")
    friction.press("Tab")
    assert page.evaluate("document.activeElement.ariaLabel") == "takeoff min [s]"
    wait_until(lambda: tuning() == {"friction": 0.4}, "the limit")
    page.get_by_text("1 number differs from the defaults.").wait_for()
    # The table is made anew with its tab.
    tab(page, "Files")
    unfold(page, "Limits")
    wait_until(lambda: friction.input_value() == "0.4", "the number again")
    page.get_by_role("button", name="Reset friction").click()
    wait_until(lambda: tuning() == {}, "the default")
    assert friction.input_value() == "0.5"
    assert not page.get_by_role("button", name="Reset friction").is_visible()


def test_beyond_its_range_a_limit_is_corrected_and_said_once(page):
    friction = page.get_by_label("friction", exact=True)
    for _ in range(2):
        friction.fill("9")
        friction.press("Enter")
        wait_until(lambda: friction.input_value() == "1.5", "the nearest")
        page.wait_for_timeout(300)
    note = page.get_by_text("friction: expected 0.1 to 1.5, got 9; the nearest is taken")
    note.first.wait_for()
    wait_until(lambda: note.count() == 1, "one note")
    page.get_by_role("button", name="Reset all").click()
    wait_until(lambda: not page.session.state.design.tuning, "the defaults")
    wait_until(lambda: friction.input_value() == "0.5", "its default")
