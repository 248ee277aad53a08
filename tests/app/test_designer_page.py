"""What makes the page a designer: pins, night, handle, reload, small screens; in a real browser."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from app.designer import Designer
from app.motion import colours
from app.workers.pool import WorkerPool
from tests.app import planners
from tests.app.chromium import (
    COMPARE,
    base_node,
    dark,
    fill,
    number,
    opened,
    paused_at,
    picture,
    press,
    status,
    tab,
    tick,
    wait_until,
)
from tests.app.nearby_planner import NEAR, NearbyPlanner

pytestmark = pytest.mark.browser


def pose(page, node):
    return page.evaluate(
        "name => window.__viserMutable.nodePoseData[name]?.position?.slice() ?? null", node
    )


def test_a_pinned_design_stays_as_a_second_robot_beside_the_next_one(page):
    tab(page, COMPARE)
    press(page, "Pin")
    wait_until(lambda: pose(page, "/pinned/1/base"), "the ghost")
    fill(page, "Forward [m]", 0.4)
    wait_until(lambda: page.session.plan.jump.forward == 0.4, "the next plan")
    status(page, "Planned")
    both = "n => llsrbm.player.clip.strands.some(s => s.tracks.some(t => t.nodes.includes(n)))"
    wait_until(lambda: page.evaluate(both, "/pinned/1/base"), "a clip with both")
    paused_at(page, 1.25)
    apart = np.subtract(pose(page, base_node(page)), pose(page, "/pinned/1/base"))
    assert apart == pytest.approx([0.4, 0, 0], abs=0.01)
    # A column for what is shown and one for what is pinned, in the colour of its ghost.
    table = page.locator("table").filter(has=page.locator('th[scope="col"]'))
    table.scroll_into_view_if_needed()
    titles = [head.get_attribute("title") for head in table.locator('th[scope="col"]').all()]
    assert len(titles) == len(set(titles)) == 2
    ghost = colours.css(colours.PINNED[0]).split("(")[1].rsplit(",", 1)[0].replace(",", ", ")
    assert ghost in table.inner_html().replace(",", ", ").replace(",  ", ", ")
    press(page, "Unpin")
    wait_until(lambda: not page.evaluate(both, "/pinned/1/base"), "a clip of one")
    wait_until(lambda: not page.get_by_role("button", name="Unpin").is_visible(), "no pins")


def test_a_pinned_design_is_taken_up_again(page):
    tab(page, COMPARE)
    press(page, "Pin")
    fill(page, "Forward [m]", 0.4)
    wait_until(lambda: page.session.plan.jump.forward == 0.4, "the next plan")
    status(page, "Planned")
    press(page, "Use this design")
    wait_until(lambda: page.session.plan.jump.forward == 0.0, "the pinned one")
    shown = number(page, "Forward [m]")
    wait_until(lambda: float(shown.input_value()) == 0.0, "the slider there")


def test_night_is_dark(page):
    def brightness():
        shot = picture(page)
        return shot[200:300, :200].mean()  # floor, left

    def panel():
        return page.evaluate("getComputedStyle(document.body).backgroundColor")

    day, light = brightness(), panel()
    tick(page, "Night")
    wait_until(lambda: brightness() < day - 60, "a dark picture")
    wait_until(lambda: panel() != light, "a dark panel")
    tick(page, "Night", ticked=False)
    wait_until(lambda: brightness() > day - 20, "the light picture")


@pytest.mark.parametrize("view", [(1024, 768), (768, 1024)])
def test_on_a_tablet_controls_and_robot_are_both_in_sight(browser, designer, view):
    width, height = view
    page = opened(browser, designer.url, {"width": width, "height": height})
    status(page, "Planned")
    paused_at(page, 0.0)

    def within(box):
        assert box is not None
        return (
            box["x"] >= 0
            and box["y"] >= 0
            and box["x"] + box["width"] <= width
            and box["y"] + box["height"] <= height
        )

    sights = {
        "Twist [deg]": number(page, "Twist [deg]"),
        "Simulate": page.get_by_role("button", name="Simulate"),
        "status": page.get_by_role("status"),
        "bar": page.locator("#llsrbm-transport"),
    }
    missing = [name for name, thing in sights.items() if not within(thing.bounding_box())]
    assert missing == []
    bar = page.locator("#llsrbm-transport").bounding_box()
    panel = number(page, "Twist [deg]").bounding_box()
    assert panel["x"] >= bar["x"] + bar["width"] or panel["y"] >= bar["y"] + bar["height"]
    # The robot: a rectangle of the picture that lies under nothing else.
    canvas = page.evaluate(
        "(({x, y, width, height}) => ({x, y, width, height}))"
        "(window.__viserMutable.canvas.getBoundingClientRect())"
    )
    free = {**canvas, "height": bar["y"] - canvas["y"]}
    assert free["width"] > 0.5 * width
    robot = np.argwhere(robot_pixels(page, free))
    assert len(robot) > 1500
    left, (bottom, right) = robot[:, 1].min(), robot.max(axis=0)
    assert left > 0
    assert right < free["width"] - 2
    assert bottom < free["height"] - 2
    assert page.faults == []
    page.context.close()


def robot_pixels(page, box):
    """Mask of the legs and the trunk in a part of the page."""
    shot = Image.open(io.BytesIO(page.screenshot(clip=box))).convert("RGB")
    return dark(np.asarray(shot).astype(int))


def test_the_handle_in_the_picture_moves_the_sliders_and_the_plan(page):
    page.evaluate(
        """owner => {
          const { sendMessage } = window.__viserMutable, name = "/goal";
          const half = Math.PI / 12;
          sendMessage({ type: "TransformControlsDragStartMessage", name, owner });
          sendMessage({ type: "TransformControlsUpdateMessage", name, owner,
            wxyz: [Math.cos(half), 0, 0, Math.sin(half)], position: [0.35, -0.12, 0.3] });
          sendMessage({ type: "TransformControlsDragEndMessage", name, owner });
        }""",
        str(page.session._client.client_id),
    )
    wait_until(lambda: page.session.plan.jump.forward == 0.35, "the plan")
    jump = page.session.plan.jump
    assert (np.degrees(jump.twist), jump.lateral, jump.height) == pytest.approx((30, -0.12, 0))
    for label, value in (("Twist [deg]", 30), ("Forward [m]", 0.35), ("Lateral [m]", -0.12)):
        shown = number(page, label)
        wait_until(lambda shown=shown, v=value: float(shown.input_value()) == v, label, 5)
    status(page, "Planned")
    wait_until(lambda: pose(page, "/goal") == pytest.approx([0.35, -0.12, 0.0]), "the handle there")


def test_the_nearest_jump_is_offered_and_taken(browser):
    designer = Designer(port=0, token="none", pool=WorkerPool(NearbyPlanner))
    try:
        page = opened(browser, designer.url)
        status(page, "Planned")
        fill(page, "Twist [deg]", round(np.degrees(planners.UNSOLVABLE)))
        offer = page.get_by_role("button", name="Use nearest feasible: twist 50 deg")
        offer.wait_for()
        told = status(page, "Failed")
        assert "reach violated in flight by 0.02 m" in told
        assert "works with twist 50 deg instead of 55" in told
        offer.click()
        status(page, "Planned")
        session = designer.sessions[-1]
        assert session.plan.jump.twist == pytest.approx(NEAR)
        assert float(number(page, "Twist [deg]").input_value()) == 50
        assert not offer.is_visible()
        assert page.faults == []
        page.context.close()
    finally:
        designer.close()
