"""The atlas in a real browser: a click opens a jump, sliders move the point."""

import pytest

from tests.app.chromium import choose, fill, number, press, status, unfold
from tests.app.waits import wait_until

MAP = ".llsrbm-atlas svg[role=application]"
MARK = "document.querySelector('.llsrbm-atlas .mark').getAttribute('transform')"


@pytest.fixture
def atlas(page):
    unfold(page, "Atlas")
    page.wait_for_function("llsrbm.atlas.map")
    page.locator(MAP).scroll_into_view_if_needed()
    return page


def cell(page, twist, forward):
    """Where the cell of a jump is in the page, pixels."""
    return page.evaluate(
        """([twist, forward]) => {
          const { x, y, jump } = llsrbm.atlas.map;
          const near = ({ centres }, value) => centres.reduce((best, centre, k) =>
            Math.abs(centre - value) < Math.abs(centres[best] - value) ? k : best, 0);
          const at = near(y, forward) * x.centres.length + near(x, twist);
          const box = document.querySelectorAll(".llsrbm-atlas .cell")[at].getBoundingClientRect();
          return [box.x + box.width / 2, box.y + box.height / 2,
            x.centres[near(x, twist)], y.centres[near(y, forward)]];
        }""",
        [twist, forward],
    )


def value(page, label):
    return float(number(page, label).input_value())


def test_a_click_moves_the_sliders_and_undo_brings_them_back(atlas):
    left, top, twist, forward = cell(atlas, -45, 0.3)
    before = value(atlas, "Twist [deg]")
    atlas.mouse.move(left, top)
    wait_until(
        lambda: atlas.evaluate("llsrbm.atlas.described").startswith("Twist −45°"), "its words"
    )
    atlas.mouse.click(left, top)
    wait_until(lambda: value(atlas, "Twist [deg]") == pytest.approx(twist), "the twist")
    assert value(atlas, "Forward [m]") == pytest.approx(forward, abs=0.006)
    status(atlas, "Feasible")
    press(atlas, "Undo")
    wait_until(lambda: value(atlas, "Twist [deg]") == before, "the twist before")


def test_the_point_of_the_design_moves_with_a_slider(atlas):
    before = atlas.evaluate(MARK)
    fill(atlas, "Twist [deg]", -90)
    wait_until(lambda: atlas.evaluate(MARK) != before, "the point")


def test_keys_choose_a_cell_and_enter_opens_it(atlas):
    atlas.locator(MAP).focus()
    time = atlas.evaluate("llsrbm.player.time")
    atlas.keyboard.press("ArrowLeft")  # the cell of the design
    atlas.keyboard.press("ArrowLeft")
    told = atlas.evaluate("llsrbm.atlas.described")
    assert told.startswith("Twist 45°")
    assert atlas.evaluate("llsrbm.player.time") == time
    atlas.keyboard.press("Enter")
    wait_until(lambda: value(atlas, "Twist [deg]") == 45, "the twist")


def test_another_colour_is_explained_and_stays_with_another_robot(atlas):
    choose(atlas, "Colour", "Limiting constraint")
    legend = atlas.locator(".llsrbm-atlas .legend")
    legend.get_by_text("none (feasible)").wait_for()
    choose(atlas, "Robot", "SLIDER")
    wait_until(
        lambda: atlas.session.state.ready and atlas.session.state.design.jump.robot == "slider",
        "the other robot",
    )
    legend.get_by_text("present design").wait_for()
    assert atlas.session.state.atlas.colour == "stopped-by"
    choose(atlas, "Colour", "Can be planned")
    legend.get_by_text("Can be planned [%]").wait_for()


def test_the_map_is_shown_large_over_the_picture(atlas):
    small = atlas.locator(MAP).bounding_box()["width"]
    larger = atlas.get_by_role("button", name="Show it large")
    larger.press("Enter")
    drawer = atlas.get_by_role("region", name="Atlas")
    drawer.wait_for()
    assert drawer.locator(MAP).bounding_box()["width"] > 2 * small
    assert atlas.get_by_label("Colour", exact=True).is_visible()
    atlas.keyboard.press("Escape")
    drawer.wait_for(state="hidden")
    assert larger.evaluate("each => each === document.activeElement")
    larger.click()
    left, top, twist, _ = cell(atlas, -45, 0.3)
    atlas.mouse.click(left, top)
    drawer.wait_for(state="hidden")
    wait_until(lambda: value(atlas, "Twist [deg]") == pytest.approx(twist), "the twist")
    press(atlas, "Undo")
