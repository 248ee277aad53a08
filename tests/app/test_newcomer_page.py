"""The first minute of a newcomer, in clicks, in a real browser.

Nothing is read: a slider is moved, the robot simulated and pushed, and a file saved, with what is
in sight or one click away. Then the examples are looked into.
"""

import pytest

from app import gallery
from tests.app.chromium import press, status
from tests.app.shared_page import visit
from tests.app.waits import wait_until

ACTIONS = 6  # in all


class Newcomer:
    """Clicks, and counts."""

    def __init__(self, page):
        self.page, self.actions = page, 0

    def click(self, role, name):
        self.actions += 1
        self.page.get_by_role(role, name=name, exact=True).click()

    def click_beside(self, slider, pixels):
        self.actions += 1
        thumb = self.page.get_by_role("slider", name=slider, exact=True).bounding_box()
        self.page.mouse.click(thumb["x"] + pixels, thumb["y"] + thumb["height"] / 2)


@pytest.fixture
def page(browser, designer):
    """Of a first visit: the tour is offered, and not in the way."""
    page = visit(browser, designer, tour=True)
    yield page
    assert page.faults == []
    page.context.close()


def test_a_newcomer_plans_simulates_pushes_saves_and_looks_into_the_examples(page):
    """What the page is has been said, and stays in sight until it is skipped."""
    welcome = page.get_by_role("dialog", name="Design a jump; see why inertia matters")
    first = welcome.locator(".example button")
    assert first.inner_text().startswith(gallery.cards()[0]["title"])
    page.wait_for_function("document.querySelector('#llsrbm-tour img').naturalWidth === 192")
    newcomer, session = Newcomer(page), page.session
    before = session.state.design.jump.twist
    newcomer.click_beside("Twist [deg]", -30)
    wait_until(lambda: session.state.plan.jump.twist < before, "the next plan")
    newcomer.click("button", "Simulate")
    status(page, "Landed")
    newcomer.click("button", "Scenario")
    newcomer.click("checkbox", "Push")
    wait_until(lambda: session.state.design.scenario.pushes, "the push")
    newcomer.click("button", "Simulate")
    wait_until(lambda: session.state.rollout and session.state.rollout.pushes, "the pushed robot")
    with page.expect_download() as download:
        newcomer.click("button", "Export")
    assert download.value.suggested_filename.endswith(".npz")
    assert newcomer.actions == ACTIONS
    press(page, "Skip")
    welcome.wait_for(state="hidden")
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
    wait_until(lambda: session.state.design.scenario.board == 0.025, "the example")
    # It was closed, and does not come again.
    page.evaluate("llsrbm.tour.offer()")
    assert not welcome.is_visible()
