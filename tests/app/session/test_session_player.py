"""Playing in one tab: by the page, or by the server for a page that does not answer."""

from __future__ import annotations

import time

import numpy as np
import pytest

from tests.app.raw_tab import RawTab, planned


def test_the_panels_buttons_are_the_pages_players(tab, script):
    tab.set("Motion", "Pause")
    tab.wait(lambda: script.calls("player.pause") == [[]], "a pause")
    tab.set("Motion", "Play")
    tab.wait(lambda: len(script.calls("player.play")) == 2, "playing again")
    tab.set("Speed", "0.25×")
    tab.wait(lambda: script.calls("player.setSpeed")[-1:] == [[0.25]], "slow motion")
    tab.set("Loop", False)
    tab.wait(lambda: script.calls("player.setLoop")[-1:] == [[False]], "no loop")


def test_the_panel_follows_the_pace_chosen_in_the_page(tab, script):
    script.say(kind="pace", speed=0.25, loop=False)
    tab.wait(lambda: (tab.value("Speed"), tab.value("Loop")) == ("0.25×", False), "that pace")
    script.say(kind="pace", speed=77.0, loop=True)
    tab.wait(lambda: tab.value("Loop") is True, "repeating")
    assert tab.value("Speed") == "0.25×"


def test_scrubbing_pauses_and_goes_to_that_instant(tab, session, script):
    tab.set("Time [s]", 0.65)
    tab.wait(lambda: script.calls("player.seek") == [[0.65]], "that instant")
    assert script.calls("player.pause") == [[]]
    apex = script.at("/com", 0.65)[0][2]
    plan = session.plan
    assert apex == pytest.approx(np.interp(0.65, plan.time, plan.com[:, 2]), abs=2e-3)
    for foot in range(4):
        assert script.at(f"/arrows/{foot}", 0.65)[2].tolist() == [0, 0, 0]
        assert script.at(f"/arrows/{foot}", 0.0)[2][2] > 0.1


def test_the_panel_follows_what_the_page_tells_unless_it_plays(tab, script):
    script.say(kind="state", time=0.52, playing=False)
    tab.wait(lambda: tab.value("Time [s]") == 0.52, "the time it stands at")
    script.say(kind="state", time=0.9, playing=True)
    script.say(kind="state", time=77.0, playing=False)
    tab.wait(lambda: tab.value("Time [s]") == pytest.approx(1.3), "the end")


@pytest.mark.parametrize(
    "nonsense",
    [
        {"kind": "state", "time": 10**400, "playing": True},
        {"kind": "state", "time": "now", "playing": []},
        {"kind": ["ready"]},
        {"kind": "pace", "speed": -1e300, "loop": True},
    ],
)
def test_what_no_page_says_changes_nothing(tab, session, script, nonsense):
    script.say(kind="state", time=0.3, playing=False)
    tab.wait(lambda: tab.value("Time [s]") == 0.3, "the time before")
    script.say(**nonsense)
    tab.set("Forward [m]", 0.15)
    planned(tab, session, lambda jump: jump.forward == 0.15, "a plan all the same")
    assert tab.value("Time [s]") == 0.3


def test_a_graphics_processor_gets_all_triangles(tab, script):
    def sizes():
        return [len(n["glb_data"]) for name, n in tab.nodes.items() if name.startswith("/links/")]

    before = sizes()
    assert len(before) == 13
    script.answer(software=False)
    tab.wait(lambda: sum(sizes()) > 2 * sum(before), "the finer robot")


def test_a_new_motion_is_sent_as_one_clip(tab, session, script):
    time.sleep(0.3)
    loads, moved = len(script.calls("player.load")), tab.received["SetPositionMessage"]
    tab.set("Forward [m]", 0.4)
    planned(tab, session, lambda jump: jump.forward == 0.4, "the new plan")
    tab.wait_for_status("Planned")
    # The one that is found quickly, and the one that is planned when the slider rests.
    assert 1 <= len(script.calls("player.load")) - loads <= 2
    # Landing marks, handle and ground; not one a frame.
    assert tab.received["SetPositionMessage"] - moved < 20
    assert script.at("/com", 1.3)[0][0] == pytest.approx(session.plan.com[-1, 0], abs=1e-5)


def test_the_timeline_reaches_the_page(script, session):
    events = script.events
    assert [row["name"] for row in events["rows"]] == ["plan"]
    assert [mark["name"] for mark in events["marks"]] == ["take-off", "apex", "touch-down planned"]
    assert events["end"] == pytest.approx(session.plan.duration)


@pytest.fixture
def silent(designer, monkeypatch):
    """A tab for which the server plays."""
    monkeypatch.setattr("app.session.stage._PATIENCE", 0.2)
    with RawTab(designer.port) as opened:
        opened.wait_for_status("Planned")
        opened.wait(lambda: opened.notifications, "what is said of it")
        yield opened


def test_the_server_plays_for_a_page_that_does_not_and_says_so(silent):
    ((title, _),) = silent.notifications
    assert title == "Played by the server"
    before = silent.received["SetPositionMessage"]
    silent.wait(lambda: silent.received["SetPositionMessage"] > before + 50, "frames")
    first = list(silent.nodes["/com"]["position"])
    silent.wait(lambda: list(silent.nodes["/com"]["position"]) != first, "motion")


def test_the_server_sends_nothing_while_paused(silent):
    silent.set("Motion", "Pause")
    time.sleep(0.4)
    before = silent.received.total()
    time.sleep(0.5)
    assert silent.received.total() == before
    silent.set("Motion", "Play")
    silent.wait(lambda: silent.received.total() > before + 100, "frames")


def test_the_server_shows_the_instant_that_is_scrubbed_to(silent, designer):
    plan = designer.sessions[-1].plan
    silent.set("Time [s]", 0.65)
    silent.wait(lambda: "\nflight\n 0.65 s of 1.30 s" in silent.text(), "the timeline at 0.65 s")
    apex = silent.nodes["/com"]["position"][2]
    assert apex == pytest.approx(np.interp(0.65, plan.time, plan.com[:, 2]), abs=2e-3)
    assert max(silent.nodes["/arrows/0"]["scale"]) == 0
    time.sleep(0.3)
    assert silent.nodes["/com"]["position"][2] == apex
    silent.set("Time [s]", 0.0)
    silent.wait(lambda: max(silent.nodes["/arrows/0"]["scale"]) == 1, "forces in stance")


def test_the_server_plays_on_from_where_the_page_was(designer, monkeypatch):
    monkeypatch.setattr("app.session.stage._PATIENCE", 3.0)
    with RawTab(designer.port) as tab:
        tab.wait_for_status("Planned")
        tab.set("Time [s]", 0.65)
        tab.wait(lambda: tab.notifications, "the server's player")
        tab.wait(lambda: "0.65 s of 1.30 s" in tab.text(), "the same instant")
        time.sleep(0.5)
        assert "0.65 s of 1.30 s" in tab.text()
