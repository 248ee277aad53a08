"""From a fresh page to the sentence on its models, in a real browser."""

import re

from tests.app.chromium import press
from tests.app.legibility import unreadable
from tests.app.shared_page import visit
from tests.app.waits import wait_until


def test_one_press_on_a_fresh_page_leads_to_a_sentence_with_figures(browser, designer):
    page = visit(browser, designer)
    press(page, "Compare models")
    card = page.get_by_role("region", name="Comparison")
    sentence = card.locator("p").filter(has_text=re.compile(r"^At touchdown SRBM has turned"))
    sentence.wait_for(timeout=60_000)
    assert len(re.findall(r"\d+\.\d+", sentence.inner_text())) >= 3
    names = card.get_by_role("list").locator("li").all_inner_texts()
    assert names == ["SRBM", "LL-SRBM", "LL-SRBM+", "Whole body"]
    # The robots stand beside each other and move together; the page plays.
    page.wait_for_function(
        "() => ['/row/0-1/base', '/row/1-1/base', '/row/2-1/base', llsrbm.camera.target.follow]"
        ".every((name) => __viserMutable.nodePoseData[name])"
    )
    assert page.evaluate("llsrbm.player.playing")
    card.get_by_text("Figures").click()
    assert card.get_by_role("row").count() == 6
    bar = page.locator("#llsrbm-transport").bounding_box()
    assert card.bounding_box()["y"] >= bar["y"]
    press(page, "Close the comparison")
    wait_until(lambda: page.session.state.comparing is None, "the server")
    card.wait_for(state="hidden")
    assert not page.faults
    page.context.close()


def test_on_a_phone_the_robots_have_room_above_the_card(browser, designer):
    page = visit(browser, designer, {"width": 390, "height": 844})
    press(page, "Compare models")
    card = page.get_by_role("region", name="Comparison")
    card.locator("p").filter(has_text=re.compile(r"^At touchdown")).wait_for(timeout=60_000)
    wait_until(lambda: card.bounding_box()["y"] > 300, "room for the picture")
    page.evaluate("llsrbm.player.pause()")
    assert unreadable(page) == []
    page.context.close()
