"""static/player.js alone, in a browser whose clock and frames are the test's."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

import app.page_template
from app.link import ClipTaken, PageReady, PlayerMoved, read_event
from app.motion.clip import AnimationChannel, Clip, Track

STATIC = Path(app.page_template.__file__).parent / "static"
STAGE = """() => {
  let now = 1000, waiting = [];
  performance.now = () => now;
  window.requestAnimationFrame = (call) => waiting.push(call);
  window.setTimeout = () => 0;
  window.pass = (frames, ms) => {
    for (let i = 0; i < frames; i++) {
      now += ms;
      const due = waiting;
      waiting = [];
      due.forEach((call) => call(now));
    }
    return llsrbm.player.time;
  };
  window.llsrbm = { software: false };
  window.sent = [];
  const node = () => ({ position: [9, 9, 9], wxyz: [1, 0, 0, 0], poseUpdateState: "updated" });
  window.__viserMutable = {
    nodePoseData: { "/a": node(), "/b": node(), "/c": node() },
    nodeRefFromName: { "/b": { scale: { set: (...s) => { window.scaled = s; } } } },
    requestRender: () => {},
    sendMessage: (message) => window.sent.push(message),
  };
  const devSettings = { get: () => ({}), set() {} };
  window.__viserTestpoints = { rendererInfo: { render: { frame: 0 } }, devSettings };
}"""

END = 2.0
TIME = np.array([0.0, 0.5, 1.0, 1.5])
WXYZ = Rotation.from_rotvec(np.outer([0.0, 0.2, 0.5, 0.4], [0, 0.6, 0.8])).as_quat(
    scalar_first=True
)
PLACE = np.array([[0.0, 0, 0], [1, 0, 2], [1, 5, 2], [3, 5, 2]])
SIZE = np.array([[1.0, 1, 0], [1, 1, 2], [1, 1, 1], [0, 0, 0]])
CLIP = Clip(
    (
        # Every other quaternion on its other side.
        AnimationChannel(TIME, (Track(("/a", "/b"), PLACE, WXYZ * [[1], [-1], [1], [-1]], SIZE),)),
        AnimationChannel(
            np.array([0.0, END]), (Track(("/c",), np.array([[0.0, 0, 0], [4, 0, 0]])),)
        ),
    ),
    END,
)


@pytest.fixture(scope="module")
def empty(browser):
    opened = browser.new_page()
    yield opened
    opened.close()


@pytest.fixture
def page(empty):
    empty.goto("about:blank")
    empty.evaluate(STAGE)
    for name in ("elements.js", "page.js", "player.js"):
        empty.evaluate((STATIC / name).read_text("utf-8"))
    empty.evaluate("llsrbm.page.connect('a field')")
    load(empty, CLIP)
    return empty


def load(page, clip):
    header, blob = clip.encoded
    page.evaluate("([header, blob]) => llsrbm.player.load(header, blob, 1)", [header, blob])


def passed(page, seconds, rate=60):
    """The time that is shown after so many seconds of frames."""
    frames = round(seconds * rate)
    return page.evaluate("([n, ms]) => pass(n, ms)", [frames, 1000 / rate])


def does(page, what):
    return page.evaluate(f"llsrbm.player.{what}")


def test_it_says_that_it_runs(page):
    message, clip = page.evaluate("sent")
    assert (message["type"], message["uuid"]) == ("GuiUpdateMessage", "a field")
    ready = read_event(message["updates"]["value"])
    assert isinstance(ready, PageReady)
    assert (ready.software, ready.missing) == (False, ())
    assert len(ready.tab) == 32
    assert read_event(clip["updates"]["value"]) == ClipTaken(1)


@pytest.mark.parametrize("instant", [0.0, 0.13, 0.5, 0.75, 1.49, 1.5, 1.9, 2.0])
def test_nodes_are_where_the_clip_has_them(page, instant):
    does(page, f"seek({instant})")
    passed(page, 0.05)
    at = min(instant, TIME[-1])  # the last instant holds
    poses = page.evaluate("__viserMutable.nodePoseData")
    for name in ("/a", "/b"):
        expected = [np.interp(at, TIME, axis) for axis in PLACE.T]
        assert poses[name]["position"] == pytest.approx(expected, abs=1e-6)
        turn = Slerp(TIME, Rotation.from_quat(WXYZ, scalar_first=True))(at)
        off = turn.inv() * Rotation.from_quat(poses[name]["wxyz"], scalar_first=True)
        assert off.magnitude() < 2e-3  # mixed along the chord
        assert np.linalg.norm(poses[name]["wxyz"]) == pytest.approx(1)
        assert poses[name]["poseUpdateState"] == "needsUpdate"
    expected = [np.interp(at, TIME, axis) for axis in SIZE.T]
    assert page.evaluate("scaled") == pytest.approx(expected, abs=1e-6)
    assert poses["/c"]["position"] == pytest.approx([2 * instant, 0, 0], abs=1e-6)
    assert poses["/c"]["wxyz"] == [1, 0, 0, 0]


@pytest.mark.parametrize("rate", [24, 60, 144])
@pytest.mark.parametrize("speed", [0.1, 0.5, 1.0])
def test_it_plays_in_real_time_times_its_speed(page, rate, speed):
    does(page, f"setSpeed({speed})")
    does(page, "play()")
    passed(page, 1 / rate, rate)  # from the first frame on
    assert passed(page, 1.0, rate) == pytest.approx(speed, abs=0.01)


def test_a_page_that_was_hidden_goes_on_where_it_was(page):
    does(page, "play()")
    before = passed(page, 0.5)
    assert page.evaluate("pass(1, 60000)") <= before + 0.11


def test_it_rests_at_the_end_then_starts_anew(page):
    does(page, "seek(1.5)")
    does(page, "play()")
    assert passed(page, 0.6) == END
    assert passed(page, 0.4) == END
    assert passed(page, 0.5) == pytest.approx(0.3, abs=0.1)
    assert does(page, "playing")


def test_a_range_is_played_again_and_again(page):
    does(page, "setRange([0.5, 1])")
    does(page, "seek(0.9)")
    does(page, "play()")
    assert passed(page, 0.4) == pytest.approx(0.75, abs=0.1)  # without a rest
    assert 0.5 <= passed(page, 2.1) <= 1.0
    # Sought behind it, the motion is played to its end, and then the range again.
    does(page, "seek(1.2)")
    assert passed(page, 0.5) > 1.5
    assert 0.5 <= passed(page, 2.0) <= 1.0
    # Without Loop there is no range.
    does(page, "setLoop(false)")
    assert passed(page, 3.0) == END


def test_a_range_may_outlast_a_clip(page):
    does(page, "setRange([1.5, Infinity])")
    load(page, Clip((AnimationChannel(np.array([0.0, 0.4]), ()),), 0.4))
    does(page, "play()")
    assert passed(page, 0.2) < 0.3
    load(page, CLIP)
    does(page, "seek(1.9)")
    assert 1.5 <= passed(page, 1.5) <= END


def test_without_loop_it_stops_and_plays_from_the_start(page):
    does(page, "setLoop(false)")
    does(page, "seek(1.5)")
    does(page, "play()")
    assert passed(page, 3.0) == END
    assert not does(page, "playing")
    does(page, "play()")
    assert passed(page, 0.5) == pytest.approx(0.5, abs=0.05)


def test_a_shorter_clip_ends_the_time_a_longer_one_goes_on(page):
    does(page, "play()")
    passed(page, 1.5)
    load(page, Clip((AnimationChannel(np.array([0.0, 0.4]), ()),), 0.4))
    assert does(page, "time") == 0.4
    load(page, CLIP)
    assert does(page, "playing")
    assert passed(page, 0.5) == pytest.approx(0.9, abs=0.05)


def test_playing_tells_the_server_nothing(page):
    does(page, "play()")
    passed(page, 0.1)
    before = len(page.evaluate("sent"))
    passed(page, 8.0)  # over the end, twice
    assert len(page.evaluate("sent")) == before


def test_the_server_is_told_what_a_hand_does_and_not_more_than_ten_times_a_second(page):
    does(page, "play()")
    passed(page, 0.5)
    does(page, "pause()")
    told = read_event(page.evaluate("sent.at(-1).updates.value"))
    assert isinstance(told, PlayerMoved)
    assert (told.time, told.playing) == (pytest.approx(0.48, abs=0.05), False)
    before = len(page.evaluate("sent"))
    page.evaluate(
        "for (let i = 0; i < 60; i++) { llsrbm.player.seek(i / 60); pass(1, 1000 / 60); }"
    )
    assert 5 <= len(page.evaluate("sent")) - before <= 11


def test_paused_it_asks_for_no_more_frames(page):
    does(page, "play()")
    passed(page, 0.5)
    does(page, "pause()")
    passed(page, 5.0)
    before = does(page, "frames")
    passed(page, 5.0)
    assert does(page, "frames") == before


def test_nothing_loaded_nothing_plays(page):
    does(page, "clear()")
    does(page, "play()")
    passed(page, 0.5)
    assert (does(page, "playing"), does(page, "time")) == (False, 0)


def test_nodes_that_come_later_find_their_place(page):
    does(page, "seek(1)")
    passed(page, 0.3)
    page.evaluate(
        "__viserMutable.nodePoseData['/c'] = {position: [9, 9, 9], poseUpdateState: 'needsUpdate'}"
    )
    passed(page, 0.3)
    late = page.evaluate("__viserMutable.nodePoseData['/c'].position")
    assert late == pytest.approx([2, 0, 0], abs=1e-6)
