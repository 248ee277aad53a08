"""The gallery of examples, in a real browser."""

from tests.app.chromium import press


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
