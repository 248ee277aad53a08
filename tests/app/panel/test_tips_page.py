"""Notes on what controls and figures mean: one at a time, on labels and figures, too."""

import pytest

from tests.app.chromium import fill, number, status
from tests.app.waits import wait_until


def notes(page):
    """The notes in sight, viser's among them."""
    return page.locator("[role=tooltip]:visible").all_inner_texts()


def test_a_label_says_what_it_means_in_one_note(page):
    page.locator("label", has_text="Forward [m]").hover()
    wait_until(lambda: notes(page), "the note")
    (text,) = notes(page)
    assert text.startswith("Landing place along the initial heading")
    assert "planned" in text  # along this slider
    page.mouse.move(10, 10)
    wait_until(lambda: not notes(page), "no note")


def test_a_figure_says_what_it_means(page):
    page.locator("dt:visible", has_text="Flight time").hover()
    wait_until(lambda: notes(page) == ["Time without any foot on the ground"], "the note")
    page.mouse.move(10, 10)


def test_a_thumb_has_one_note_and_keeps_its_name(page):
    thumb = page.get_by_role("slider", name="Twist [deg]", exact=True)
    thumb.hover()
    wait_until(lambda: notes(page), "the note")
    assert thumb.get_attribute("title") == ""
    page.mouse.move(10, 10)
    assert page.get_by_role("slider", name="Twist [deg]", exact=True).count() == 1


@pytest.mark.parametrize(("label", "other"), [("Twist [deg]", "-12"), ("Forward [m]", "-0.1")])
def test_a_number_box_keeps_its_number_and_says_what_it_accepts(page, label, other):
    box, design = number(page, label), page.session.state.design
    before = box.input_value()
    box.click()
    page.keyboard.press("Control+a")
    page.keyboard.insert_text("abc")
    wait_until(lambda: notes(page), "the note")
    (note,) = notes(page)
    assert note.startswith(f"{label}: expected a number from −")
    assert box.input_value() == before
    page.keyboard.insert_text(other)
    assert box.input_value() == other
    page.keyboard.press("Escape")
    wait_until(lambda: page.session.state.design != design, "the number's request")


@pytest.mark.parametrize("left", ["", "-", "."])
def test_a_number_box_that_is_left_without_a_number_has_its_last_one_again(page, left):
    box = number(page, "Forward [m]")
    before = box.input_value()
    box.click()
    page.keyboard.press("Control+a")
    page.keyboard.press("Delete")
    page.keyboard.insert_text(left)
    assert box.input_value() == left
    page.keyboard.press("Enter")
    wait_until(lambda: box.input_value() == before, "the number")
    (note,) = notes(page)
    assert note.startswith("Forward [m]: expected a number from −")
    page.keyboard.press("Control+a")
    page.keyboard.press("Delete")
    page.keyboard.press("Tab")
    wait_until(lambda: box.input_value() == before, "the number again")
    page.keyboard.press("Escape")


def test_keys_undo_what_was_changed_and_redo_it(page):
    def planned():
        # The example is put back late: what was filled in before is lost.
        if page.session.state.design.jump.forward != 0.2:
            fill(page, "Forward [m]", 0.2)
        return page.session.state.plan.jump.forward == 0.2

    wait_until(planned, "its plan")
    status(page, "Feasible")
    plan = page.session.state.plan
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Control+z")
    wait_until(lambda: float(number(page, "Forward [m]").input_value()) == 0, "the one before")
    page.keyboard.press("Control+y")
    wait_until(lambda: page.session.state.plan is plan, "the same plan, without planning")
