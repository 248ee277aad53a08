"""Nothing on the page is cut, small, crowded, pale or covered, at any size, by day and by night.

Nor does axe-core find anything serious or critical, in viser's controls neither:
static/accessibility.js and static/panel.js supply the names and contrasts that viser lacks.
"""

import pytest

from tests.app.axe import findings
from tests.app.chromium import PACE, drop, settled, tab, tick, unfold
from tests.app.legibility import unreadable

DESK, TABLET = (1440, 900), (820, 1180)
SIZES = [DESK, (1280, 720), (1920, 1080), (390, 844)]
AGAIN = 500  # ms
# Tabs of the panel, and the folders in them.
PLACES = {
    "View": ("More overlays",),
    "Results": (),
    "Plots": (),
    "Files": (),
    "More": ("Footholds", "Slopes", "Limits", "Atlas"),
}


def at_night(page, night):
    tick(page, "Dark mode", ticked=night)
    scheme = "dark" if night else "light"
    page.locator(f":root[data-mantine-color-scheme={scheme}]").wait_for(state="attached")
    page.wait_for_timeout(PACE)


def laid_out(page):
    """All that cannot be read, once that stays as it is: another layout takes its time to come."""
    settled(page)
    before, found = None, unreadable(page)
    while found != before:
        page.wait_for_timeout(AGAIN)
        before, found = found, unreadable(page)
    return found


@pytest.mark.parametrize(
    ("size", "night"),
    [
        pytest.param(DESK, False, id="desk by day"),
        pytest.param(TABLET, True, id="tablet by night", marks=pytest.mark.nightly),
    ],
)
def test_everything_can_be_read(page, size, night):
    page.set_viewport_size(dict(zip(("width", "height"), size, strict=True)))
    at_night(page, night)
    unfold(page, "Scenario")
    page.get_by_label("Push", exact=True).check()
    page.get_by_label("Push x [N s]", exact=True).wait_for()
    found = {}
    for name, folders in PLACES.items():
        tab(page, name)
        for folder in folders:
            unfold(page, folder)
        settled(page)
        found[name] = unreadable(page) + findings(page)
    tab(page, "View")
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        found[width, height] = laid_out(page)
    assert {place: findings for place, findings in found.items() if findings} == {}


def test_a_note_can_be_read_at_night(page):
    at_night(page, True)
    drop(page, "other.npz", b"no such file")
    page.get_by_text("other.npz: not an npz file").wait_for()
    assert laid_out(page) == []
