"""The dialog of exports, in a real browser."""

import pytest

from llsrbm.formats import FORMATS
from tests.app.axe import findings
from tests.app.chromium import press
from tests.app.waits import wait_until


@pytest.fixture
def shown(page):
    """The dialog, opened."""
    press(page, "Export…")
    dialog = page.get_by_role("dialog", name="Export")
    dialog.wait_for()
    yield dialog
    page.evaluate("document.getElementById('llsrbm-exports').close()")


def test_formats_stand_under_what_they_are_for_and_some_cannot_be_chosen(page, shown):
    headings = ["For simulation", "For learning", "For the robot", "To look at"]
    assert shown.get_by_role("heading", level=3).all_inner_texts() == headings
    items = shown.get_by_role("listitem")
    assert items.count() == len(FORMATS)
    lowcmd = items.filter(has_text="lowcmd")
    assert "ANYmal B has no table" in lowcmd.inner_text()
    assert lowcmd.get_by_role("button").count() == 0
    assert "anymal_twist90_unitree.csv" in items.filter(has_text="unitree-csv").inner_text()
    assert shown.evaluate("each => each.scrollWidth === each.clientWidth")


def test_a_press_chooses_the_format_and_saves_the_file(page, shown):
    with page.expect_download() as download:
        shown.get_by_role("button", name="unitree-csv").click()
    shown.wait_for(state="hidden")
    assert download.value.suggested_filename == "anymal_twist90_unitree.csv"
    wait_until(lambda: page.session.state.export.format == "unitree-csv", "the choice")
    assert page.get_by_label("Format", exact=True).input_value() == "unitree-csv"


def test_the_keyboard_is_enough(page):
    button = page.get_by_role("button", name="Export…", exact=True)
    button.focus()
    page.keyboard.press("Enter")
    dialog = page.get_by_role("dialog", name="Export")
    dialog.wait_for()
    assert page.evaluate("document.activeElement.closest('#llsrbm-exports') !== null")
    page.keyboard.press("Escape")
    dialog.wait_for(state="hidden")
    assert button.evaluate("each => each === document.activeElement")


@pytest.mark.parametrize("night", [False, True], ids=["day", "night"])
def test_it_can_be_read(page, shown, night):
    scheme = "dark" if night else "light"
    page.evaluate("s => document.documentElement.dataset.mantineColorScheme = s", scheme)
    assert findings(page, "#llsrbm-exports") == []
    sizes = shown.evaluate(
        """each => [...each.querySelectorAll("*")].filter(e => e.innerText)
          .map(e => parseFloat(getComputedStyle(e).fontSize))"""
    )
    assert min(sizes) >= 12
    page.evaluate("document.documentElement.dataset.mantineColorScheme = 'light'")
