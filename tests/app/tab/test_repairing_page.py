"""Another tool's motion in a real browser: dropped, repaired, beside its plan, undone."""

from dataclasses import replace

import numpy as np

from tests.app.axe import findings
from tests.app.chromium import drop, press, settled, status
from tests.app.legibility import unreadable
from tests.app.planners import turning_states
from tests.app.shared_page import visit
from tests.app.waits import wait_until

SIZES = [(1440, 1000), (1280, 720), (768, 1024), (390, 844)]
BROKEN = "1 of 3 checks broken (1 not known): joint speed 116.4 % at FL_calf_joint (0.74 s)."


def content(motion):
    """As a table that Unitree's tools read."""
    rows = [motion.base_position, np.roll(motion.base_quat, -1, 1), motion.joint_position]
    return "\n".join(",".join(f"{x:.9f}" for x in row) for row in np.hstack(rows)).encode()


def without_note(page):
    """Close viser's own note on the file, which it shows again in a narrower page."""
    note = page.get_by_text("uploaded successfully")

    def closed():
        page.evaluate(
            "document.querySelectorAll('.mantine-Notification-closeButton')"
            ".forEach((each) => each.click())"
        )
        return note.count() == 0

    wait_until(closed, "the note to go")


def test_a_dropped_motion_is_repaired_and_stands_beside_its_plan(browser, designer):
    page = visit(browser, designer)
    before = page.session.state.plan
    drop(page, "turn.csv", content(turning_states("anymal").motion()))
    card = page.get_by_role("region", name="Comparison")
    card.locator("p").filter(has_text=BROKEN).wait_for()
    without_note(page)
    page.wait_for_function("__viserMutable.nodePoseData['/row/0-1/base']")
    assert unreadable(page) == []
    assert findings(page) == []
    repair = page.get_by_role("button", name="Repair", exact=True)
    repair.focus()
    page.keyboard.press("Enter")
    after = "After: all 3 checks hold. Moved: joints 0.052 rad (rms), base 3.4 cm (rms)"
    card.locator("p").filter(has_text=after).wait_for()
    names = card.get_by_role("list").locator("li").all_inner_texts()
    assert names == ["Before: turn.csv", "After: turn.csv, repaired"]
    assert repair.count() == 0
    status(page, "Feasible")
    repaired = page.session.state.plan
    assert repaired is not before
    page.evaluate("llsrbm.player.pause()")
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        settled(page)
        without_note(page)
        assert unreadable(page) == []
    assert findings(page) == []
    page.set_viewport_size({"width": 1280, "height": 800})
    press(page, "Undo")
    repair.wait_for()
    wait_until(lambda: page.session.state.plan is before, "the plan before")
    press(page, "Redo")
    wait_until(lambda: page.session.state.plan is repaired, "the repaired one")
    press(page, "Close the comparison")
    card.wait_for(state="hidden")
    wait_until(lambda: page.session.state.foreign is None, "the server")
    assert not page.faults
    page.context.close()


def test_without_a_flight_there_is_none(browser, designer):
    page = visit(browser, designer)
    motion = turning_states("anymal").motion()
    still = replace(motion, base_quat=np.repeat(motion.base_quat[:1], len(motion.time), axis=0))
    drop(page, "still.csv", content(still))
    press(page, "Repair")
    card = page.get_by_role("region", name="Comparison")
    card.locator("p").filter(has_text="Not repaired: No foot leaves the ground").wait_for()
    status(page, "Failed")
    assert unreadable(page) == []
    assert not page.faults
    page.context.close()
