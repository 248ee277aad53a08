"""What makes the page a designer: pins, night, small screens; in a real browser."""

import numpy as np
import pytest

from app.motion import colours
from tests.app.chromium import (
    COMPARE,
    base_node,
    dark,
    fill,
    number,
    paused_at,
    picture,
    press,
    screenshot,
    status,
    tab,
    tick,
)
from tests.app.shared_page import shows_motion
from tests.app.waits import wait_until


def pose(page, node):
    return page.evaluate(
        "name => window.__viserMutable.nodePoseData[name]?.position?.slice() ?? null", node
    )


HANDLE = """() => {
  const found = new Set();
  window.__viserMutable.nodeRefFromName["/goal"]?.traverse(({ material, visible }) =>
    visible && material?.color && found.add(material.color.getHexString()));
  return [...found];
}"""


def test_the_landing_handle_has_the_colour_of_the_landing(page):
    target = "".join(f"{part:02x}" for part in colours.TARGET)
    wait_until(lambda: page.evaluate(HANDLE) == [target], "the colour")
    tick(page, "Landing handle", ticked=False)
    wait_until(lambda: page.evaluate(HANDLE) == [], "no handle")
    tick(page, "Landing handle")
    wait_until(lambda: page.evaluate(HANDLE) == [target], "the colour again")


def test_a_pinned_design_stays_as_a_second_robot_beside_the_next_one(page):
    tab(page, COMPARE)
    press(page, "Pin")
    wait_until(lambda: pose(page, "/pinned/1/base"), "the ghost")
    fill(page, "Forward [m]", 0.4)
    wait_until(lambda: page.session.state.plan.jump.forward == 0.4, "the next plan")
    status(page, "Feasible")
    both = "n => llsrbm.player.clip.channels.some(s => s.tracks.some(t => t.nodes.includes(n)))"
    wait_until(lambda: page.evaluate(both, "/pinned/1/base"), "a clip with both")
    paused_at(page, 1.25)
    apart = np.subtract(pose(page, base_node(page)), pose(page, "/pinned/1/base"))
    assert apart == pytest.approx([0.4, 0, 0], abs=0.01)
    # A column for what is shown and one for what is pinned, in the colour of its ghost.
    table = page.locator("table:visible").filter(has=page.locator('th[scope="col"]'))
    table.scroll_into_view_if_needed()
    titles = [head.get_attribute("title") for head in table.locator('th[scope="col"]').all()]
    assert len(titles) == len(set(titles)) == 2
    ghost = colours.css(colours.PINNED[0]).split("(")[1].rsplit(",", 1)[0].replace(",", ", ")
    assert ghost in table.inner_html().replace(",", ", ").replace(",  ", ", ")
    press(page, "Unpin")
    wait_until(lambda: not page.evaluate(both, "/pinned/1/base"), "a clip of one")
    wait_until(lambda: not page.get_by_role("button", name="Unpin").is_visible(), "no pins")


def test_night_is_dark(page):
    def brightness():
        shot = picture(page)
        return shot[200:300, :200].mean()  # floor, left

    def panel():
        return page.evaluate("getComputedStyle(document.body).backgroundColor")

    day, light = brightness(), panel()
    tick(page, "Dark mode")
    wait_until(lambda: brightness() < day - 60, "a dark picture")
    wait_until(lambda: panel() != light, "a dark panel")
    tick(page, "Dark mode", ticked=False)
    wait_until(lambda: brightness() > day - 20, "the light picture")


def test_the_whole_bodys_plan_follows_unless_it_is_switched_off(page):
    """By default the whole body's plan follows the draft; the checkbox stays with drafts."""
    tab(page, "More")
    box = page.get_by_label("Whole body", exact=True)
    assert box.is_checked()
    box.uncheck()
    fill(page, "Forward [m]", 0.2)
    assert "in knots only" in status(page, "Draft as")
    assert not page.session.state.plan.refined
    box.check()
    status(page, "Feasible")
    assert page.session.state.plan.refined
    box.uncheck()
    status(page, "Draft as")


def test_on_a_tablet_controls_and_robot_are_both_in_sight_however_it_is_held(page):
    page.set_viewport_size({"width": 1024, "height": 768})
    page.reload()
    shows_motion(page)
    paused_at(page, 0.0)
    assert_in_sight(page, 1024, 768)
    page.set_viewport_size({"width": 768, "height": 1024})
    assert_in_sight(page, 768, 1024)


def assert_in_sight(page, width, height):
    def within(box):
        right, below = box["x"] + box["width"], box["y"] + box["height"]
        return min(box["x"], box["y"]) >= 0 and right <= width and below <= height

    sights = {
        "Twist [deg]": number(page, "Twist [deg]"),
        "Simulate": page.get_by_role("button", name="Simulate"),
        "status": page.get_by_role("status"),
        "bar": page.locator("#llsrbm-transport"),
    }
    for name, thing in sights.items():
        wait_until(lambda t=thing: within(t.bounding_box()), f"{name} in sight")

    def apart():
        bar = page.locator("#llsrbm-transport").bounding_box()
        panel = number(page, "Twist [deg]").bounding_box()
        return panel["x"] >= bar["x"] + bar["width"] or panel["y"] >= bar["y"] + bar["height"]

    wait_until(apart, "bar and panel beside or above each other")

    def robot_is_in_sight():
        """The robot: a rectangle of the picture that lies under nothing else."""
        canvas = page.evaluate(
            "(({x, y, width, height}) => ({x, y, width, height}))"
            "(window.__viserMutable.canvas.getBoundingClientRect())"
        )
        bar = page.locator("#llsrbm-transport").bounding_box()
        free = {**canvas, "height": bar["y"] - canvas["y"]}
        if free["width"] <= 0.5 * width or free["height"] < 100:
            return False
        robot = np.argwhere(dark(screenshot(page, clip=free)))
        if len(robot) <= 1500:
            return False
        left, (bottom, right) = robot[:, 1].min(), robot.max(axis=0)
        return left > 0 and right < free["width"] - 2 and bottom < free["height"] - 2

    # Panel, bar and camera settle one after the other once the window has another size.
    wait_until(robot_is_in_sight, "the robot between bar and panel")
