"""Chips of what is pinned, over the picture, in a real browser."""

from tests.app.chromium import COMPARE, fill, press, status, tab
from tests.app.waits import wait_until


def test_what_is_pinned_is_a_chip_over_the_picture(page):
    session, chips = page.session, page.get_by_role("group", name="Pinned designs")
    assert not chips.is_visible()
    tab(page, COMPARE)
    press(page, "Pin")
    chips.get_by_role("button", name="Side by side").wait_for()
    fill(page, "Forward [m]", 0.3)
    wait_until(lambda: session.state.plan.jump.forward == 0.3, "the plan")
    status(page, "Feasible")
    assert chips.locator(".name").all_inner_texts() == [
        "90° + 30 cm forward whole body", "90° whole body"
    ]  # fmt: skip
    # At the top right of the picture, and clear of the camera's buttons.
    canvas, box = page.locator("canvas").first.bounding_box(), chips.bounding_box()
    assert box["x"] + box["width"] <= canvas["x"] + canvas["width"]
    camera = page.get_by_role("toolbar", name="Camera").bounding_box()
    assert box["x"] > camera["x"] + camera["width"]
    beside = chips.get_by_role("button", name="Side by side")
    assert beside.get_attribute("aria-pressed") == "false"
    beside.click()
    wait_until(lambda: session.state.beside, "the server")
    page.wait_for_function(
        "() => Object.entries(__viserMutable.nodePoseData).some(([name, { position }]) =>"
        " name.startsWith('/row/') && name.endsWith('/base') && position[1] > 0.8)"
    )
    press(page, "Side by side")
    wait_until(lambda: not session.state.beside, "the server")
    press(page, "Use 90° whole body")
    wait_until(lambda: session.state.plan.jump.forward == 0, "the pinned design")
    # The two have one name now, and get numbers as soon as the page hears of it.
    chips.get_by_title("Unpin").click()
    wait_until(lambda: not session.state.pins, "no pin")
    chips.wait_for(state="hidden")
