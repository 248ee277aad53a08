"""The verdict in a browser: what it says, and that nothing moves when it changes."""

from __future__ import annotations

import pytest

from tests.app.chromium import fill, number, press, status

pytestmark = pytest.mark.browser


def places(page):
    """Where the controls below the verdict are."""
    boxes = [number(page, "Twist [deg]"), page.get_by_role("button", name="Simulate", exact=True)]
    return [box.bounding_box() for box in boxes]


def test_a_refusal_moves_nothing_and_its_nearest_is_taken(page):
    remark = page.locator("#llsrbm-remark")
    before = places(page)
    assert not remark.is_visible()
    fill(page, "Twist [deg]", -170)
    text = status(page, "Nearest")
    assert "−150° instead of −170°" in text
    assert "RH_HAA needs 107 Nm at lift-off, it has 34." in text
    assert remark.inner_text() == "Nearest: −150° instead of −170°"
    assert places(page) == before
    press(page, "Use nearest")
    status(page, "Feasible")
    assert number(page, "Twist [deg]").input_value() == "-150"
    assert not remark.is_visible()
    assert places(page) == before


def test_a_landing_is_told_in_three_figures(page):
    before = places(page)
    press(page, "Simulate")
    text = status(page, "Landed")
    assert [word in text for word in ("Yaw error", "Tilt", "Foot error")] == [True] * 3
    assert places(page) == before
