"""The labels that a visitor reads in the panel."""

from tests.app.chromium import FOLDERS, unfold

_VISIBLE = """() => [...document.querySelectorAll("label, button, [role=tab]")]
  .filter((e) => e.getClientRects().length && !e.closest("[data-dock-area] canvas"))
  .filter((e) => !e.closest(".mantine-Notification-root"))
  .map((e) => (e.getAttribute("aria-label") || e.innerText).trim())
  .filter((text) => text && text.length < 60 && !/[\\n]/.test(text))"""


def labels(page):
    """Labels of boxes, fields, buttons and tabs, of every tab of the panel: sorted, each once."""
    page.get_by_role("button", name="Pause", exact=True).wait_for()  # it opens playing
    page.get_by_role("button", name="Copy as SVG").first.wait_for()  # of its first chart
    found = set(page.evaluate(_VISIBLE))
    for folder in FOLDERS:
        unfold(page, folder)
    for tab in page.locator("[data-dock-area^=gui-tabs]").get_by_role("tab").all():
        tab.click()
        found.update(page.evaluate(_VISIBLE))
    page.get_by_role("button", name="Show it large").wait_for()  # the map, in the last tab
    found.update(page.evaluate(_VISIBLE))
    return sorted(found)
