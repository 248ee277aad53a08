"""The verdict in a browser: what it says, that it is never cut, and what moves when it grows."""

from tests.app.chromium import fill, number, press, status


def places(page):
    """Where the slider above the verdict and the button below it are."""
    boxes = [number(page, "Twist [deg]"), page.get_by_role("button", name="Simulate", exact=True)]
    return [box.bounding_box() for box in boxes]


def is_whole(page):
    """Whether all that it says is in sight."""
    return page.get_by_role("status").evaluate(
        "each => each.scrollHeight <= each.clientHeight && each.scrollWidth <= each.clientWidth"
    )


def test_a_refusal_is_told_in_full_and_its_nearest_is_taken(page):
    remark = page.locator("#llsrbm-remark")
    before = places(page)
    assert not remark.is_visible()
    fill(page, "Twist [deg]", -170)
    text = status(page, "Nearest")
    assert "−150° instead of −170°" in text
    assert "RH_HAA needs 107 Nm at lift-off, it has 34." in text
    assert remark.inner_text() == "Nearest: −150° instead of −170°"
    assert is_whole(page)
    assert places(page)[0] == before[0]  # a slider stays under the hand
    press(page, "Use nearest")
    status(page, "Feasible")
    assert number(page, "Twist [deg]").input_value() == "-150"
    assert not remark.is_visible()
    assert places(page) == before


def test_a_landing_is_told_in_four_figures(page):
    before = places(page)
    press(page, "Simulate")
    text = status(page, "Landed")
    words = ("Yaw error", "Tilt", "Foot error", "Peak torque")
    assert [word in text for word in words] == [True] * 4
    assert is_whole(page)
    assert places(page) == before
