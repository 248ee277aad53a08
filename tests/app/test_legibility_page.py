"""Nothing on the page is cut, small, crowded, pale or covered, at any size, by day and by night."""

from __future__ import annotations

import pytest

from tests.app.chromium import FOLDERS, PACE, settled, tab, tick, unfold
from tests.app.legibility import unreadable
from tests.app.shared_page import visit

pytestmark = pytest.mark.browser

SIZES = [(1440, 900), (1280, 720), (1920, 1080), (390, 844)]
TABS = ("View", "Results", "Plots", "Files", "More")


@pytest.fixture(scope="module")
def page(browser, designer):
    page = visit(browser, designer, {"width": 1440, "height": 900})
    page.evaluate("llsrbm.player.pause()")
    page.evaluate(
        "document.querySelectorAll('.mantine-Notification-closeButton').forEach(b => b.click())"
    )
    yield page
    assert page.faults == []
    page.context.close()


def at_night(page, night):
    tick(page, "Dark mode", ticked=night)
    scheme = "dark" if night else "light"
    page.locator(f":root[data-mantine-color-scheme={scheme}]").wait_for(state="attached")
    page.wait_for_timeout(PACE)


@pytest.mark.parametrize("night", [False, True], ids=["day", "night"])
def test_everything_can_be_read(page, night):
    page.set_viewport_size({"width": 1440, "height": 900})
    at_night(page, night)
    found = {}
    for folder in FOLDERS:
        unfold(page, folder)
    for name in TABS:
        tab(page, name)
        settled(page)
        found[name] = unreadable(page)
    tab(page, "View")
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        settled(page)
        found[width, height] = unreadable(page)
    assert {place: findings for place, findings in found.items() if findings} == {}
