"""axe-core over the page: all tabs and folders, on a desk by day and on an upright tablet by night.

Nothing serious or critical is found, in viser's controls neither: static/accessibility.js and
static/panel.js supply the names and contrasts that viser lacks.
"""

from __future__ import annotations

from importlib.resources import files

import pytest

from tests.app.chromium import FOLDERS, PACE, tab, unfold
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
    "Help",
)

RUN = """async () => {
  const found = await axe.run(document, {
    runOnly: ["wcag2a", "wcag2aa"], resultTypes: ["violations"],
  });
  return found.violations
    .filter(({ id, impact }) => ["serious", "critical"].includes(impact))
    .flatMap(({ id, nodes }) => nodes.map(({ html, failureSummary: why }) =>
      `${id}: ${html.slice(0, 300)} | ${why.slice(0, 300)}`));
}"""


@pytest.fixture(scope="module")
def page(browser, designer):
    package = pytest.importorskip("axe_playwright_python")
    page = visit(browser, designer, DESK)
    page.evaluate("llsrbm.player.pause()")  # drawing in software would take axe's processor
    page.add_script_tag(content=(files(package) / "axe.min.js").read_text("utf-8"))
    yield page
    assert page.faults == []
    page.context.close()


def findings(page):
    found = {}
    for place in PLACES:
        (unfold if place in FOLDERS else tab)(page, place)
        page.wait_for_timeout(600)
        found |= dict.fromkeys((line, place) for line in page.evaluate(RUN))
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
    assert findings(page) == []
