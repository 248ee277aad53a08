"""The gallery of examples, in a real browser."""

from app import gallery
from tests.app.chromium import press

# Whether a stick figure of the list is drawn anew.
MOVES = """() => {
  const path = document.querySelector("#llsrbm-gallery .motions button svg path:last-child");
  if (!path) return false;
  window.drawnBefore ??= path.getAttribute("d");
  return path.getAttribute("d") !== window.drawnBefore;
}"""


def test_the_button_opens_it_and_its_pictures_are_sent_once(page):
    shown = page.get_by_role("dialog", name="Examples")
    for number in range(2):
        before = sum(page.heard)
        press(page, "Examples")
        shown.wait_for()
        if number:
            assert sum(page.heard) - before < 50_000
        assert page.evaluate("document.activeElement.closest('#llsrbm-gallery') !== null")
        page.keyboard.press("Escape")
        shown.wait_for(state="hidden")


def test_stick_figures_come_as_their_cards_come_into_view(page):
    press(page, "Examples")
    shown = page.get_by_role("dialog", name="Examples")
    motions = shown.get_by_role("region", name="Library").locator(".motions button")
    last = motions.last
    assert last.locator("svg").count() == 0
    last.scroll_into_view_if_needed()
    last.locator("svg").wait_for(state="attached")
    assert motions.locator("svg").count() < motions.count()


def test_a_motion_of_the_library_is_filtered_and_opened(page):
    press(page, "Examples")
    shown = page.get_by_role("dialog", name="Examples")
    section = shown.get_by_role("region", name="Library")
    motions = [motion for motion in gallery.motions() if motion["kind"] == "Pirouette"]
    section.get_by_label("Kind").select_option("Pirouette")
    buttons = section.locator(".motions button")
    assert buttons.count() == len(motions)
    buttons.first.scroll_into_view_if_needed()
    page.wait_for_function(MOVES)
    section.get_by_label("Made for").select_option(motions[0]["robot"])
    buttons.first.click()
    shown.wait_for(state="hidden")
    page.get_by_text(f"Opened {motions[0]['name']}.").wait_for()
