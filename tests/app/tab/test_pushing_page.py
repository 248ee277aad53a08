"""A push drawn with the mouse, simulated with replanning and compared; in a real browser."""

import numpy as np
import pytest

from tests.app.chromium import PACE, PIXELS, at_rest, paused_at, press, status, tick, unfold
from tests.app.waits import wait_until

GRIP = "/push/tip"
DRAG = 0.4  # m


@pytest.fixture
def page(page):
    """With a push in mid-flight, the mouse nowhere near it."""
    unfold(page, "Scenario")
    page.get_by_label("Push", exact=True).check()
    page.wait_for_timeout(PACE)
    wait_until(lambda: len(pushes(page)) == 1, "the push")
    page.wait_for_function(f"window.__viserMutable.nodeRefFromName['{GRIP}']?.visible")
    at_rest(page)  # robot, arrow and camera are where they stay
    yield page
    unfold(page, "Scenario")
    for label in ("Push", "Replan"):
        page.get_by_label(label, exact=True).set_checked(False)
        page.wait_for_timeout(PACE)
    wait_until(lambda: not pushes(page) and not replans(page), "no push")


def pushes(page):
    return page.session.state.design.scenario.pushes


def replans(page):
    return page.session.state.design.scenario.replan


def drag(page, axis, length):
    """Draw the tip along an axis."""
    points = np.zeros((2, 3))
    points[1, axis] = length
    grab, there = np.array(page.evaluate(PIXELS, [GRIP, *points.tolist()]))
    page.mouse.move(*grab)
    page.wait_for_timeout(PACE)
    page.mouse.down()
    for share in np.linspace(0, 1, 5):
        page.mouse.move(*(grab + share * (there - grab)))
        page.wait_for_timeout(PACE)
    page.mouse.up()


def simulated(page):
    page.wait_for_timeout(PACE)

    def is_up_to_date():
        rollout = page.session.state.rollout
        return rollout is not None and rollout.scenario == page.session.state.design.scenario

    # What was simulated by itself meanwhile is not what is waited for.
    wait_until(is_up_to_date, "the simulation")
    return page.session.state.rollout


def visible(page, node):
    """Whether a node of the scene has a size and is shown."""
    return page.evaluate(
        "name => { const node = window.__viserMutable.nodeRefFromName[name];"
        " return Boolean(node?.visible) && node.scale.z > 0; }",
        node,
    )


def test_a_push_is_drawn_and_what_comes_of_it_is_played(page):
    (before,) = pushes(page)
    drag(page, 0, -DRAG)
    rollout = simulated(page)
    (push,) = rollout.scenario.pushes
    assert push.time == before.time
    assert push.impulse[1:] == pytest.approx(before.impulse[1:], abs=0.2)  # a pixel or two
    # As far as the hand goes: 2 m an m/s.
    expected = before.impulse[0] - DRAG / 2 * page.session.state.robot.mass
    assert push.impulse[0] == pytest.approx(expected, rel=0.2)
    page.wait_for_function("llsrbm.player.playing")
    assert page.evaluate("llsrbm.player.time") >= push.time
    assert page.get_by_label("Push x [N s]", exact=True).input_value() == f"{push.impulse[0]:g}"
    press(page, "Undo")
    wait_until(lambda: pushes(page) == (before,), "the push of before")


def test_its_arrow_is_seen_while_it_acts(page):
    (push,) = pushes(page)
    press(page, "Simulate")
    status(page, "Landed")
    arrow = "/push/past/arrow/0"
    page.wait_for_function(f"window.__viserMutable.nodeRefFromName['{arrow}']")
    for time, seen in (
        (push.time + 0.02, True),
        (push.time - 0.1, False),
        (push.time + 0.2, False),
    ):
        paused_at(page, time)
        assert visible(page, arrow) == seen
    words = page.locator("#llsrbm-transport .mark", has_text="N s")
    assert words.inner_text() == f"push {np.linalg.norm(push.impulse):.3g} N s"


def test_computing_times_are_bars_under_the_timeline(page):
    assert page.locator("#llsrbm-transport .bar").count() == 0
    page.get_by_label("Replan", exact=True).check()
    page.wait_for_timeout(PACE)
    press(page, "Simulate")
    rollout = simulated(page)
    bars = page.locator("#llsrbm-transport .bar")
    page.wait_for_function("document.querySelector('#llsrbm-transport .bar')")
    assert bars.count() == len(rollout.replans)
    in_time = page.locator("#llsrbm-transport .bar.in-time")
    assert (
        0
        < in_time.count()
        == sum(replan.solved and replan.computing_time <= 0.02 for replan in rollout.replans)
    )
    replan = rollout.replans[3]
    assert (
        bars.nth(3)
        .get_attribute("title")
        .endswith(f"{1e3 * replan.computing_time:.1f} ms of 20 ms")
    )
    strip = page.locator("#llsrbm-transport .bars").bounding_box()
    box = bars.nth(3).bounding_box()
    end = page.evaluate("llsrbm.player.clip.end")
    assert (box["x"] + 2 - strip["x"]) / strip["width"] == pytest.approx(
        replan.measured / end, abs=0.01
    )
    assert box["height"] / strip["height"] == pytest.approx(replan.computing_time / 0.04, abs=0.1)
    taken = next(replan.applied for replan in rollout.replans if np.isfinite(replan.applied))
    paused_at(page, taken + 0.01)
    assert visible(page, "/anew/foothold/0")
    tick(page, "New plans", ticked=False)
    page.wait_for_function("!window.__viserMutable.nodeRefFromName['/anew']?.visible")
