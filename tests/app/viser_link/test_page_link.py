from __future__ import annotations

import json
import math
from types import SimpleNamespace
from unittest.mock import MagicMock

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.motion.clip import Clip
from app.viser_link import page_link as bridge
from app.viser_link.page_link import PaceChosen, PageLink, PageReady, PlayerMoved, read_event
from llsrbm.motion.timeline import Mark, Piece, Row, Timeline
from tests.app.page_script import call

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=6,
)
LIKELY = st.fixed_dictionaries(
    {"kind": st.sampled_from(["ready", "state", "pace"]) | JSON},
    optional=dict.fromkeys(("software", "time", "playing", "speed", "loop"), JSON),
)


@pytest.mark.parametrize(
    ("told", "event"),
    [
        ({"kind": "ready", "software": True, "count": 1}, PageReady(True)),
        ({"kind": "state", "time": 0.5, "playing": False}, PlayerMoved(0.5, False)),
        ({"kind": "state", "time": 1, "playing": True}, PlayerMoved(1.0, True)),
        ({"kind": "pace", "speed": 0.25, "loop": True}, PaceChosen(0.25, True)),
    ],
)
def test_what_the_page_says_is_read(told, event):
    assert read_event(json.dumps(told)) == event


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
        '{"kind": "pace", "speed": 1e999, "loop": true}',
        '{"kind": "ready"}',
        '{"kind": "state", "time": 0.5, "playing": true, "more": "' + "x" * 1000 + '"}',
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
        case PaceChosen(speed, loop):
            assert math.isfinite(speed)
            assert isinstance(loop, bool)
        case PageReady(software):
            assert isinstance(software, bool)
        case _:
            assert event is None


@pytest.fixture
def sent(monkeypatch):
    scripts = []
    monkeypatch.setattr(bridge, "run_javascript", lambda _, source: scripts.append(source))
    monkeypatch.setattr(bridge, "uuid_of", lambda _: "a field")
    return scripts


def test_everything_is_a_call_of_the_pages_scripts(sent):
    made = PageLink(SimpleNamespace(gui=MagicMock()), lambda _: None)
    made.play()
    made.pause()
    made.seek(0.25)
    made.set_speed(0.5)
    made.set_loop(False)
    made.clear()
    assert [call(source) for source in sent] == [
        ("player.connect", ["a field"]),
        ("player.play", []),
        ("player.pause", []),
        ("player.seek", [0.25]),
        ("player.setSpeed", [0.5]),
        ("player.setLoop", [False]),
        ("player.clear", []),
        ("transport.hide", []),
    ]


def test_a_timeline_is_sent_with_colours_as_style_sheets_have_them(sent):
    made = PageLink(SimpleNamespace(gui=MagicMock()), lambda _: None)
    row = Row('a "row"', (Piece("flight", 0.4, 0.9, (1, 2, 3), low=True),))
    made.load(
        Clip((), 1.0, {"twist": 0.5}),
        Timeline((row,), (Mark("apex", 0.6, (4, 5, 6)),), "told", 1.3),
    )
    *_, load, (function, (shown,)) = (call(source) for source in sent)
    assert load == ("player.load", [{"end": 1.0, "request": {"twist": 0.5}, "strands": []}, ""])
    assert function == "transport.show"
    piece = {"name": "flight", "start": 0.4, "end": 0.9, "colour": "rgba(1,2,3,1)", "low": True}
    assert shown == {
        "rows": [{"name": 'a "row"', "pieces": [piece]}],
        "marks": [{"name": "apex", "time": 0.6, "colour": "rgba(4,5,6,1)"}],
        "told": "told",
        "end": 1.3,
    }
