"""The motion that the page plays by itself, its bar and its keys, in a real browser."""

import numpy as np
import pytest

from app.tab.planning.beginning import LATER
from tests.app.chromium import (
    base_node,
    number,
    paused_at,
    player,
    press,
    settled,
    status,
    tab,
    tick,
)
from tests.app.waits import eventually, wait_until

FRAME = 1 / 60  # s
POSE = """name => {
  const { position, wxyz } = window.__viserMutable.nodePoseData[name];
  return { time: llsrbm.player.time, position: [...position], wxyz: [...wxyz] };
}"""


@pytest.fixture
def page(page):
    """Paused at 0.5 s."""
    paused_at(page, 0.5)
    return page


def expected(session, node, time):
    """(position, wxyz) of a node in the clip that was sent, mixed between its instants."""
    clip = session._rendering._scene._clip()
    for strand in clip.channels:
        for track in strand.tracks:
            if node in track.nodes:
                position, wxyz = (
                    np.array([np.interp(time, strand.time, axis) for axis in values.T])
                    for values in (track.position, track.wxyz)
                )
                return position, wxyz / np.linalg.norm(wxyz)
    raise AssertionError(f"{node} does not move")


def test_it_plays_in_real_time_and_the_server_says_nothing(page):
    base = base_node(page)
    player(page, "play()")
    heard = None
    while heard != len(page.heard):  # of what was done before, and of the draft made later
        heard = len(page.heard)
        page.wait_for_timeout(1e3 * LATER + 500)
    assert heard > 0
    poses = []
    for _ in range(8):
        poses.append(page.evaluate(POSE, base))
        page.wait_for_timeout(100)
    assert len(page.heard) == heard
    assert len({pose["time"] for pose in poses}) >= 4
    for pose in poses:
        position, wxyz = expected(page.session, base, pose["time"])
        assert pose["position"] == pytest.approx(position, abs=1e-4)
        assert abs(np.dot(pose["wxyz"], wxyz)) == pytest.approx(1, abs=1e-4)


def test_without_repeating_it_stops_at_the_end_and_says_so(page):
    page.get_by_role("button", name="Loop", exact=True).click()
    assert player(page, "loop") is False
    paused_at(page, player(page, "clip.end") - 0.1)
    player(page, "play()")
    wait_until(lambda: not player(page, "playing"), "the end", 5)
    wait_until(lambda: not page.session.state.playback.playing, "the server to know", 5)
    page.get_by_role("button", name="Loop", exact=True).click()
    assert player(page, "loop") is True


def test_keys_step_and_are_no_commands_in_a_field(page):
    what_is_typed_into_a_field_is_no_command(page)
    page.evaluate("document.activeElement.blur()")
    arrows = {"ArrowRight": 1, "ArrowLeft": -1, "Shift+ArrowRight": 6, "Shift+ArrowLeft": -6}
    for key, frames in arrows.items():
        player(page, "play()")
        page.keyboard.press(key)
        assert not player(page, "playing")
        paused_at(page, 0.5)
        page.keyboard.press(key)
        assert player(page, "time") == pytest.approx(0.5 + frames * FRAME, abs=1e-9)
        # The camera stays where it is.
        assert page.evaluate("window.scrollX + window.scrollY") == 0


def what_is_typed_into_a_field_is_no_command(page):
    number(page, "Forward [m]").focus()
    for key in ("Home", "ArrowLeft", "ArrowRight", "End", "Space"):
        page.keyboard.press(key)
    assert player(page, "time") == 0.5
    assert not player(page, "playing")


def test_space_belongs_to_the_button_that_has_the_focus(page):
    """Clicked or reached with the keys, it is pressed again."""
    press(page, "Play")
    assert player(page, "playing")
    page.keyboard.press("Space")
    page.wait_for_function("!llsrbm.player.playing")


def test_the_pages_keys_can_be_switched_off(page):
    for on in (False, True):
        tick(page, "Keyboard shortcuts", ticked=on)
        page.wait_for_function(f"llsrbm.shortcuts === {str(on).lower()}")
        page.evaluate("document.activeElement.blur()")
        before = player(page, "time")
        page.keyboard.press("ArrowRight")
        assert (player(page, "time") > before) is on


def test_with_the_keyboard_space_presses_the_button_and_arrows_choose_the_tab(page):
    page.get_by_role("button", name="Loop").focus()
    page.keyboard.press("Tab")  # as who uses the keyboard comes to a control
    page.keyboard.press("Shift+Tab")
    before = player(page, "loop")
    page.keyboard.press("Space")
    page.wait_for_function(f"llsrbm.player.loop === {str(not before).lower()}")
    assert not player(page, "playing")
    page.keyboard.press("ArrowRight")  # no button uses it
    assert player(page, "time") > 0.5
    tab(page, "View")
    page.get_by_role("tab", name="View").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowLeft")
    time = player(page, "time")
    page.keyboard.press("ArrowRight")
    assert player(page, "time") == time
    assert page.evaluate("document.activeElement.role") == "tab"


def test_the_bar_is_scrubbed(page):
    box = page.get_by_role("group", name="Timeline").bounding_box()
    end, middle = player(page, "clip.end"), box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + box["width"] / 4, middle)
    page.mouse.down()
    assert player(page, "time") == pytest.approx(end / 4, rel=0.02)
    page.mouse.move(box["x"] + box["width"] * 0.75, middle)
    assert player(page, "time") == pytest.approx(0.75 * end, rel=0.02)
    page.mouse.move(box["x"] + 2 * box["width"], middle)
    assert player(page, "time") == end
    page.mouse.up()
    page.mouse.move(box["x"], middle)
    assert player(page, "time") == end
    # The server is told, and the panel with it.
    wait_until(lambda: page.session.state.playback.time == pytest.approx(end), "the server", 5)


def drag(page, x, to):
    """Press at (x, y), and let go at another x."""
    page.mouse.move(*x)
    page.mouse.down()
    page.mouse.move(to, x[1], steps=3)
    page.mouse.up()


def test_a_range_is_chosen_by_its_handles(page):
    track = page.get_by_role("group", name="Timeline").bounding_box()
    end = player(page, "clip.end")
    first, last = (page.get_by_role("slider", name=f"Loop {side}") for side in ("from", "until"))
    for handle, share in ((first, 0.25), (last, 0.75)):
        box = handle.bounding_box()
        place = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        drag(page, place, track["x"] + share * track["width"])
    assert player(page, "range") == pytest.approx([end / 4, 0.75 * end], rel=0.02)
    assert player(page, "time") == 0.5
    first.focus()
    page.keyboard.press("ArrowRight")
    assert player(page, "range")[0] == pytest.approx(end / 4 + FRAME, rel=0.02)
    assert player(page, "time") == 0.5  # the key was the handle's
    # With Shift a range is drawn over the strips; a double-click on a handle takes it back.
    page.keyboard.down("Shift")
    middle = track["y"] + 0.6 * track["height"]
    drag(page, (track["x"] + 0.5 * track["width"], middle), track["x"] + 0.6 * track["width"])
    page.keyboard.up("Shift")
    assert player(page, "range") == pytest.approx([0.5 * end, 0.6 * end], rel=0.02)
    first.dblclick()
    assert player(page, "range") is None


def test_the_timeline_zooms(page):
    track = page.get_by_role("group", name="Timeline")
    box, end = track.bounding_box(), player(page, "clip.end")
    button = page.get_by_role("button", name="Zoom", exact=True)

    def seen():
        """The times at both ends, s: where a press seeks to."""
        found = []
        for x in (1, box["width"] - 1):
            page.mouse.click(box["x"] + x, box["y"] + 0.6 * box["height"])
            found.append(player(page, "time"))
        return pytest.approx(found, abs=0.01)

    page.evaluate("llsrbm.player.setRange([0.4, 0.9])")
    button.click()
    assert seen() == [0.4, 0.9]
    assert page.locator("#llsrbm-transport .mark[title=apex]").is_visible()
    assert page.locator("#llsrbm-transport .mark[title=push-off]").count() == 0
    # The motion that leaves the part in sight takes it along.
    page.evaluate("llsrbm.player.setRange(null)")
    paused_at(page, 0.85)
    player(page, "play()")
    page.wait_for_function("llsrbm.player.time > 1")
    player(page, "pause()")
    assert page.locator("#llsrbm-transport .cursor").is_visible()
    button.click()
    assert seen() == [0.0, end]
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + 0.6 * box["height"])
    page.mouse.wheel(0, -400)
    page.wait_for_function("llsrbm.timeline.zoomed")
    assert seen() == [0.22 * end, 0.78 * end]
    track.dblclick(position={"x": 50, "y": 0.6 * box["height"]})
    assert seen() == [0.0, end]


def test_phases_and_marks_are_where_they_happen(page):
    plan = page.session.state.plan
    bar = page.locator("#llsrbm-transport")
    track = page.get_by_role("group", name="Timeline").bounding_box()

    def share(box):
        return (box["x"] - track["x"]) / track["width"]

    phases = (("take-off", "all feet"), ("flight", "no foot"), ("landing", "all feet"))
    for (name, feet), start in zip(phases, plan.phase_start, strict=False):
        piece = bar.locator(f'[title="plan: {name} (standing: {feet})"]').bounding_box()
        assert share(piece) == pytest.approx(start / plan.duration, abs=0.01)
    marks = {"lift-off": plan.phase_start[1], "touchdown": plan.phase_start[2]}
    for name, time in marks.items():
        mark = bar.locator(f'.mark[title="{name}"]').bounding_box()
        assert share(mark) == pytest.approx(time / plan.duration, abs=0.01)
    assert bar.locator('.mark[title="apex"]').count() == 1
    assert "lift-off 0.40 s" in bar.inner_text()
    for instant, phase in ((0.1, "take-off"), (0.6, "flight"), (1.2, "landing")):
        paused_at(page, instant)
        assert f"{instant:.2f} / 1.30 s {phase}" in bar.inner_text()


LABELS = """() => [...document.querySelectorAll("#llsrbm-transport .mark span")]
  .filter(label => getComputedStyle(label).visibility === "visible")
  .map(label => {
    const { left, right, top, bottom } = label.getBoundingClientRect();
    return { text: label.textContent, left, right, top, bottom };
  })"""


def test_labels_of_the_timeline_lie_over_nothing(page):
    press(page, "Simulate")
    status(page, "Landed")
    assert page.locator("#llsrbm-transport .names > div").all_inner_texts() == [
        "plan", "simulation", "time [s]",
    ]  # fmt: skip
    for width in (1280, 820):
        page.set_viewport_size({"width": width, "height": 800})
        settled(page)
        eventually(assert_labels_lie_over_nothing, page)  # the bar follows the picture


def assert_labels_lie_over_nothing(page):
    marks = page.locator("#llsrbm-transport .mark")
    titles = [mark.get_attribute("title") for mark in marks.all()]
    assert len(titles) >= 4  # push-off, lift-off, apex, touchdown, first contact ...
    labels = page.evaluate(LABELS)
    assert {"push-off", "lift-off", "apex", "touchdown"} <= {label["text"] for label in labels}
    track = page.get_by_role("group", name="Timeline").bounding_box()
    line = page.locator("#llsrbm-transport .line").bounding_box()
    rows = page.locator("#llsrbm-transport .row").first.bounding_box()
    for i, one in enumerate(labels):
        assert one["left"] >= track["x"] - 1
        assert one["right"] <= track["x"] + track["width"] + 1
        assert one["top"] >= line["y"] + line["height"] - 1
        assert one["bottom"] <= rows["y"] + 1
        for other in labels[:i]:
            apart = one["right"] <= other["left"] or other["right"] <= one["left"]
            assert apart or one["bottom"] <= other["top"] or other["bottom"] <= one["top"]
    # Without a label, the mark's own title has to do.
    assert {label["text"] for label in labels} <= set(titles)
