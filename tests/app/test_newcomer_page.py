"""The first minute of a newcomer, in clicks, in a real browser.

Nothing is read: a slider is moved, the robot simulated and pushed, and a file saved, with what is
in sight or one click away.
"""

from __future__ import annotations

import pytest

from tests.app.chromium import status
from tests.app.shared_page import visit
from tests.app.waits import wait_until

pytestmark = pytest.mark.browser

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


def test_a_newcomer_plans_simulates_pushes_and_saves(page):
    newcomer, session = Newcomer(page), page.session
    before = session.design.jump.twist
    newcomer.click_beside("Twist [deg]", -30)
    wait_until(lambda: session.plan.jump.twist < before, "the next plan")
    newcomer.click("button", "Simulate")
    status(page, "Landed")
    newcomer.click("button", "Scenario")
    newcomer.click("checkbox", "Push")
    wait_until(lambda: session.design.scenario.pushes, "the push")
    newcomer.click("button", "Simulate")
    wait_until(lambda: session.rollout and session.rollout.pushes, "the pushed robot")
    with page.expect_download() as download:
        newcomer.click("button", "Export")
    assert download.value.suggested_filename.endswith(".npz")
    assert newcomer.actions == ACTIONS
