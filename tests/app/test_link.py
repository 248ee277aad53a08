import ast
import json
import math
import queue
import re
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app import link as page_link
from app.link import (
    ApexDragged,
    BesideChosen,
    CertificateAsked,
    ChartDropped,
    ClipTaken,
    PageLink,
    PageReady,
    PartAsked,
    PartPlotted,
    PhasesDragged,
    PinPressed,
    PlaybackChosen,
    PlayerMoved,
    PushDragged,
    RepairAsked,
    read_event,
)
from app.motion.clip import Clip
from llsrbm.look.timeline import Mark, Piece, Strip, Timeline
from llsrbm.request.tuning import Tuning
from tests.app.page_script import call

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=6,
)
FIELDS = (
    *("software", "time", "playing", "speed", "loop", "number"),
    *("missing", "tab", "shared", "kept"),
)
LIKELY = st.fixed_dictionaries(
    {"kind": st.sampled_from(["ready", "state", "playback", "clip"]) | JSON},
    optional=dict.fromkeys(FIELDS, JSON),
)


@pytest.mark.parametrize(
    ("message", "event"),
    [
        ({"kind": "ready", "software": True, "count": 1}, PageReady(True)),
        ({"kind": "state", "time": 0.5, "playing": False}, PlayerMoved(0.5, False)),
        ({"kind": "state", "time": 1, "playing": True}, PlayerMoved(1.0, True)),
        ({"kind": "playback", "speed": 0.25, "loop": True}, PlaybackChosen(0.25, True)),
        ({"kind": "clip", "number": 3}, ClipTaken(3)),
        ({"kind": "pin", "act": "unpin", "index": 1}, PinPressed("unpin", 1)),
        ({"kind": "certificate"}, CertificateAsked()),
        ({"kind": "beside", "on": True}, BesideChosen(True)),
        ({"kind": "repair"}, RepairAsked()),
        ({"kind": "chart", "chart": None, "onto": "Yaw"}, ChartDropped(None, "Yaw")),
        (
            {
                "kind": "ready",
                "software": False,
                "missing": ["a", "b"],
                "tab": "0f" * 16,
                "shared": "{}",
                "kept": "[]",
                "time": 0.5,
                "playing": True,
            },
            PageReady(False, ("a", "b"), "0f" * 16, "{}", "[]", 0.5, True),
        ),
        ({"kind": "ready", "software": True, "tab": None, "kept": ""}, PageReady(True)),
        ({"kind": "ready", "software": True, "height": 800}, PageReady(True, height=800.0)),
        ({"kind": "part", "part": "LF_KFE"}, PartAsked("LF_KFE")),
        (
            {"kind": "phases", "durations": [0.4, 0.5], "begins": True},
            PhasesDragged((0.4, 0.5), begins=True),
        ),
        (
            {"kind": "phases", "durations": [], "begins": False},
            PhasesDragged((), begins=False),
        ),
        ({"kind": "apex", "height": 0.6, "begins": True}, ApexDragged(0.6, begins=True)),
        ({"kind": "apex", "height": None, "begins": True}, ApexDragged(None, begins=True)),
        ({"kind": "plot", "part": "LF_KFE", "row": 2}, PartPlotted("LF_KFE", 2)),
        (
            {"kind": "push", "time": 0.5, "x": 0.1, "y": -1, "ended": True},
            PushDragged(0.5, 0.1, -1.0, True),
        ),
    ],
)
def test_reports_of_the_page_are_read(message, event):
    assert read_event(json.dumps(message)) == event


@pytest.mark.parametrize(
    "nonsense",
    [
        None,
        3,
        b"{}",
        "",
        "{",
        "[]",
        '{"kind": "state", "time": NaN, "playing": true}',
        '{"kind": "state", "time": Infinity, "playing": true}',
        '{"kind": "state", "time": "1", "playing": true}',
        '{"kind": "state", "time": 1, "playing": 1}',
        '{"kind": "playback", "speed": 1e999, "loop": true}',
        '{"kind": "playback", "speed": -1, "loop": true}',
        '{"kind": "clip", "number": 1e999}',
        '{"kind": "clip", "number": NaN}',
        '{"kind": "pin", "act": "use", "index": -1}',
        '{"kind": "pin", "act": "burn", "index": 0}',
        '{"kind": "beside", "on": 1}',
        '{"kind": "phases", "durations": [0.4, -0.1], "begins": true}',
        '{"kind": "phases", "durations": [NaN], "begins": true}',
        '{"kind": "phases", "durations": [' + "1," * 20 + '1], "begins": true}',
        '{"kind": "apex", "height": Infinity, "begins": true}',
        '{"kind": "apex", "height": 0.6}',
        '{"kind": "state", "time": -1, "playing": true}',
        '{"kind": "ready"}',
        '{"kind": "ready", "software": true, "tab": "../../x"}',
        '{"kind": "ready", "software": true, "kept": 3}',
        '{"kind": "part", "part": "' + "x" * 200 + '"}',
        '{"kind": "plot", "part": "LF_KFE", "row": -1}',
        '{"kind": "push", "time": 1, "x": NaN, "y": 0, "ended": true}',
        '{"kind": "push", "time": 1, "x": 0, "y": 0, "ended": 1}',
        '{"kind": "state", "time": 0.5, "playing": true, "more": "' + "x" * 200_000 + '"}',
        "[" * 999,
        '{"kind": "state", "time": true, "playing": true}',
        '{"kind": "state", "time": 1' + "0" * 400 + ', "playing": true}',
    ],
)
def test_what_no_page_says_is_nothing(nonsense):
    assert read_event(nonsense) is None


@settings(max_examples=60)
@given(st.text() | JSON | JSON.map(json.dumps) | LIKELY.map(json.dumps))
def test_whatever_is_said_nothing_breaks(message):
    event = read_event(message)
    match event:
        case PlayerMoved(time, playing):
            assert math.isfinite(time)
            assert isinstance(playing, bool)
        case PlaybackChosen(speed, loop):
            assert 0 < speed <= 1
            assert isinstance(loop, bool)
        case ClipTaken(number):
            assert number >= 0
        case PageReady(software, missing):
            assert isinstance(software, bool)
            assert all(isinstance(name, str) for name in missing)
        case _:
            assert event is None


@pytest.fixture
def sent(monkeypatch):
    scripts = []
    monkeypatch.setattr(page_link, "run_javascript", lambda _, source: scripts.append(source))
    monkeypatch.setattr(page_link, "uuid_of", lambda _: "a field")
    return scripts


@pytest.fixture
def link(sent):
    return PageLink(SimpleNamespace(gui=MagicMock()), lambda _: None)


def test_everything_is_a_call_of_the_pages_scripts(link, sent):
    link.call("player.play")
    link.call("player.seek", 0.25)
    link.call("page.keep", '{"a": "</script>"}')
    link.call("tuning.show", Tuning({"force": 2.0}))
    assert [call(source) for source in sent] == [
        ("page.connect", ["a field"]),
        ("player.play", []),
        ("player.seek", [0.25]),
        ("page.keep", ['{"a": "</script>"}']),
        ("tuning.show", [{"weights": {"force": 2.0}, "limits": {}}]),
    ]


APP = Path(page_link.__file__).parent


def test_every_function_that_is_called_is_in_the_scripts(shared_page):
    trees = [ast.parse(path.read_text("utf-8")) for path in APP.rglob("*.py")]
    called = {
        node.args[0].value
        for tree in trees
        for node in ast.walk(tree)
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Attribute)
        and node.func.attr == "call"
        and isinstance(node.args[0], ast.Constant)
    }
    assert len(called) > 15
    absent = """names => names.filter((name) => {
      const [owner, method] = name.split(".");
      return typeof llsrbm[owner]?.[method] !== "function";
    })"""
    assert shared_page.evaluate(absent, sorted(called)) == []


def test_the_scripts_send_every_kind_of_event_and_no_other():
    scripts = "".join(path.read_text("utf-8") for path in (APP / "static").glob("*.js"))
    sent = set(re.findall(r'\bkind: "([a-z-]+)", ?|send\(\{ kind: "([a-z-]+)"', scripts))
    assert set(page_link.EVENTS) == {one or other for one, other in sent}


TIMELINE = Timeline(
    (Strip('a "row"', (7, 8, 9), (Piece("flight", 0.4, 0.9, (1, 2, 3), low=True),)),),
    (Mark("apex", 0.6, (4, 5, 6)),),
    "events",
    1.3,
)


def test_a_timeline_is_sent_with_colours_as_style_sheets_have_them(link, sent):
    link.load(Clip((), 1.0, {"twist": 0.5}), TIMELINE)
    *_, (function, (shown,)), load = (call(source) for source in sent)
    assert load[0] == "player.load"
    header, blob, number = load[1]
    assert (header["end"], header["request"], header["channels"]) == (1.0, {"twist": 0.5}, [])
    assert (blob, number) == ("", 1)
    assert function == "transport.show"
    piece = {
        "name": "flight",
        "start": 0.4,
        "end": 0.9,
        "colour": "rgba(1,2,3,1)",
        "low": True,
        "feet": "",
    }
    assert shown["rows"] == [{"name": 'a "row"', "colour": "rgba(7,8,9,1)", "pieces": [piece]}]
    assert shown["marks"] == [{"name": "apex", "time": 0.6, "colour": "rgba(4,5,6,1)"}]
    assert shown["end"] == 1.3


def loaded(sent):
    """Ends and numbers of the clips that were sent."""
    calls = [call(source) for source in sent]
    return [(args[0]["end"], args[2]) for name, args in calls if name == "player.load"]


def test_a_slow_page_gets_the_newest_clip_next(link, sent):
    for end in (1.0, 2.0, 3.0, 4.0):
        link.load(Clip((), end), TIMELINE)
    assert loaded(sent) == [(1.0, 1)]
    link.take(ClipTaken(1))
    assert loaded(sent) == [(1.0, 1), (4.0, 2)]
    link.load(Clip((), 5.0), None)
    link.take(ClipTaken(1))  # said twice
    link.take(ClipTaken(77))  # never sent
    assert loaded(sent) == [(1.0, 1), (4.0, 2), (5.0, 3)]


def test_a_lost_acknowledgement_does_not_stop_the_picture(sent, monkeypatch):
    monkeypatch.setattr(page_link, "_OVERDUE", 0.01)
    events = queue.Queue()
    link = PageLink(SimpleNamespace(gui=MagicMock()), events.put)
    link.load(Clip((), 1.0), TIMELINE)
    link.load(Clip((), 2.0), TIMELINE)
    assert loaded(sent) == [(1.0, 1)]
    link.take(events.get(timeout=10))
    assert loaded(sent) == [(1.0, 1), (2.0, 2)]


def test_commands_wait_for_the_clip_that_they_are_about(link, sent):
    link.load(Clip((), 1.0), None)
    link.load(Clip((), 2.0), TIMELINE)
    link.call("player.seek", 1.5)
    link.call("player.play")
    assert [call(source)[0] for source in sent][-1] == "player.load"
    link.take(ClipTaken(1))
    names = [call(source)[0] for source in sent]
    assert names[-4:] == ["transport.show", "player.load", "player.seek", "player.play"]
    link.take(ClipTaken(2))
    assert len(sent) == len(names)
