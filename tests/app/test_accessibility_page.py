"""axe-core over the page: all tabs and folders, on a desk by day and on an upright tablet by night.

Nothing serious or critical is found, in viser's controls neither: static/accessibility.js and
static/panel.js supply the names and contrasts that viser lacks.
"""

from __future__ import annotations

import pytest

from tests.app.axe import findings
from tests.app.chromium import FOLDERS, PACE, settled, tab, unfold
from tests.app.shared_page import visit

pytestmark = pytest.mark.browser

DESK, TABLET = {"width": 1280, "height": 800}, {"width": 820, "height": 1180}
PLACES = (
    "View",
    "More overlays",
    "Results",
    "Plots",
    "Files",
    "Scenario",
    "Limits",
    "Atlas",
)


@pytest.fixture(scope="module")
def page(browser, designer):
    page = visit(browser, designer, DESK)
    page.evaluate("llsrbm.player.pause()")  # drawing in software would take axe's processor
    yield page
    assert page.faults == []
    page.context.close()


def all_findings(page):
    found = {}
    for place in PLACES:
        (unfold if place in FOLDERS else tab)(page, place)
        settled(page)
        found |= dict.fromkeys((line, place) for line in findings(page))
    return list(found)


@pytest.mark.parametrize(
    ("view", "night"), [(DESK, False), (TABLET, True)], ids=["desk by day", "tablet by night"]
)
def test_nothing_serious_is_found(page, view, night):
    page.set_viewport_size(view)
    tab(page, "View")
    box = page.get_by_label("Dark mode", exact=True)
    if box.is_checked() != night:
        box.set_checked(night)
        scheme = "dark" if night else "light"
        page.locator(f":root[data-mantine-color-scheme={scheme}]").wait_for(state="attached")
        page.wait_for_timeout(PACE)
    assert all_findings(page) == []
