"""The gallery of examples, in a real browser."""

from __future__ import annotations

import pytest

from app import gallery
from tests.app.chromium import press
from tests.app.shared_page import visit
from tests.app.waits import wait_until

pytestmark = pytest.mark.browser


def test_a_first_visit_says_what_the_page_is_and_leads_to_the_examples(browser, designer):
    page = visit(browser, designer, tour=True)
    welcome = page.get_by_role("dialog", name="Design a jump; see why inertia matters")
    first = welcome.locator(".example button")
    assert first.inner_text().startswith(gallery.cards()[0]["title"])
    page.wait_for_function("document.querySelector('#llsrbm-tour img').naturalWidth === 192")
    press(page, "Skip")
    assert not welcome.is_visible()
    press(page, "Examples")
    shown = page.get_by_role("dialog", name="Examples")
    shown.wait_for()
    cards = shown.locator(".cards button")
    assert cards.count() == len(gallery.designs())
    page.wait_for_function(
        "() => [...document.querySelectorAll('#llsrbm-gallery img')]"
        ".every((image) => image.complete && image.naturalWidth === 192)"
    )
    cards.filter(has_text="ANYmal onto a board").click()
    shown.wait_for(state="hidden")
    wait_until(lambda: page.session.design.scenario.board == 0.025, "the example")
    # It was closed, and does not come again.
    page.reload()
    page.wait_for_function("window.llsrbm?.player?.clip")
    page.evaluate("llsrbm.tour.offer()")
    assert not page.locator("#llsrbm-tour").is_visible()
    assert not page.faults
    page.context.close()


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
