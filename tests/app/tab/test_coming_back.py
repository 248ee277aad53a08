"""Tabs that go and come back, over a connection and without a browser."""

import logging
import threading
from contextlib import closing

import pytest

from app.designer import Designer
from app.guard.limits import Limits
from app.tab.effects import LoadRobot, loaded
from app.tab.tabs import KEPT
from app.workers.pool import WorkerPool
from tests.app.planners import SyntheticPlanner
from tests.app.raw_tab import RawTab, pinned, planned
from tests.app.waits import wait_until

LOOPS = 30


def token(number):
    return f"{number:032x}"


def session_of(designer, tab):
    """The server's side of a tab, by its token: of two, the newer one."""
    return [each for each in designer.sessions if each.token == tab.page.known["tab"]][-1]


def opened(designer, number, **known):
    """A tab whose page has a token, when it is known to the server."""
    before = designer.sessions
    tab = RawTab(designer.port, {"tab": token(number), **known})

    def known_now():
        new = [each for each in designer.sessions if each not in before]
        return any(each.state.page and each.token == token(number) for each in new)

    tab.wait(known_now, "its session")
    return tab


def gone(designer, session):
    wait_until(lambda: session not in designer.sessions, "the session's end")


def worked_on(designer, number):
    """A tab with a plan, a pin, a simulation and a place on the timeline."""
    tab = opened(designer, number)
    tab.set("Forward [m]", 0.2)
    session = session_of(designer, tab)
    planned(tab, session, lambda jump: jump.forward == 0.2, "a plan")
    tab.wait_for_status("Feasible")
    tab.press("Pin")
    tab.wait(lambda: len(pinned(tab)) == 1, "a ghost")
    tab.press("Simulate")
    tab.wait_for_status("Landed")
    tab.page.say(kind="state", time=0.7, playing=False)
    wait_until(lambda: session.state.playback.time == 0.7, "the place")
    return tab, session


@pytest.mark.parametrize("lost", [False, True], ids=["a reload", "a lost connection"])
def test_a_tab_finds_everything_again(designer, lost):
    number = 1 + lost
    tab, before = worked_on(designer, number)
    if not lost:
        tab.close()
        gone(designer, before)
    again = opened(designer, number, **({"time": 0.9, "playing": True} if lost else {}))
    session = session_of(designer, again)
    try:
        assert session is not before
        again.wait_for_status("Landed")
        again.wait(lambda: len(pinned(again)) == 1, "the pin's ghost")
        assert again.value("Forward [m]") == 0.2
        assert session.state.plan is before.state.plan
        assert session.state.rollout is before.state.rollout
        again.wait(lambda: again.page.calls("player.seek"), "its place")
        assert {"/shade/base", "/links/base"} < again.page.nodes()
        assert again.page.calls("player.seek") == [[0.9 if lost else 0.7]]
        again.wait(lambda: len(again.page.calls("player.play")) == lost, "its motion")
        gone(designer, before)
        again.set("Forward [m]", 0.25)
        planned(again, session, lambda jump: jump.forward == 0.25, "the next plan")
    finally:
        again.close()
        tab.close()


def test_each_tab_finds_its_own(designer):
    tabs = [opened(designer, number) for number in (3, 4)]
    for tab, forward in zip(tabs, (0.1, 0.3), strict=True):
        tab.set("Forward [m]", forward)
        session = session_of(designer, tab)
        planned(tab, session, lambda jump, f=forward: jump.forward == f, "a plan")
        tab.wait_for_status("Feasible")
    for tab in tabs:
        tab.close()
    for number, forward in ((4, 0.3), (3, 0.1), (5, 0.0)):
        with opened(designer, number) as again:
            again.wait_for_status("Feasible")
            assert session_of(designer, again).state.plan.jump.forward == forward


def test_a_page_that_greets_late_finds_its_tab_again(designer, monkeypatch):
    tab, before = worked_on(designer, 6)
    tab.close()
    gone(designer, before)
    monkeypatch.setattr("app.tab.session._PAGE_ANSWERS", 0.0)
    with RawTab(designer.port, None) as again:
        again.wait_for_status("Feasible")
        again.page.known = {"tab": token(6)}
        again.page.greet()
        again.wait_for_status("Landed")
        assert session_of(designer, again).state.rollout is before.state.rollout
        assert len(pinned(again)) == 1


def test_states_are_dropped_after_their_time_and_beyond_their_number(designer, monkeypatch):
    tabs, now = designer.tabs, [1000.0]
    monkeypatch.setattr(tabs, "_clock", lambda: now[0])
    monkeypatch.setattr(tabs, "_kept", {})
    tab = opened(designer, 8)
    tab.wait_for_status("Feasible")
    session = session_of(designer, tab)
    tab.close()
    gone(designer, session)
    assert token(8) in tabs._kept
    now[0] += KEPT - 1
    assert tabs._take_kept(token(8)) is not None
    tabs._session_ended(session)
    now[0] += KEPT + 1
    assert tabs._take_kept(token(8)) is None
    most = 7  # the server's limit of tabs, see `Designer`
    monkeypatch.setattr(tabs, "_most_kept", most)
    for number in range(most + 5):
        session.token = token(100 + number)
        tabs._session_ended(session)
    assert len(tabs._kept) == most
    assert tabs._take_kept(token(104)) is None
    assert tabs._take_kept(token(105)) is not None


def test_as_many_states_are_kept_as_tabs_may_be_open():
    """After a cut, each finds its own."""
    pool = WorkerPool(SyntheticPlanner, processes=1)
    with closing(pool), closing(Designer(port=0, limits=Limits(tabs=3), pool=pool)) as small:
        assert small.tabs._most_kept == 3


def test_tabs_that_close_at_once_leave_nothing_behind(designer):
    # Pages that other tests share may be open.
    others, threads = set(designer.sessions), set(threading.enumerate())
    for number in range(LOOPS):
        known = {} if number % 2 else {"tab": token(200 + number % 3)}
        RawTab(designer.port, known).close()
    wait_until(lambda: set(designer.sessions) <= others, "the sessions' end")

    def left():
        found = set(threading.enumerate()) - threads
        return [thread for thread in found if thread.name.startswith("session-")]

    wait_until(lambda: not left(), "the threads' end")
    assert len(designer.tabs._kept) <= Limits.tabs
    with RawTab(designer.port) as tab:
        tab.wait_for_status("Feasible")


def test_a_session_that_cannot_be_built_says_so(designer, monkeypatch, caplog):
    def broken(*_args, **_options):
        raise ZeroDivisionError("a defect")

    with monkeypatch.context() as patched, caplog.at_level(logging.ERROR):
        patched.setattr("app.tab.session.Rendering", broken)
        with RawTab(designer.port, {"tab": token(9)}) as tab:
            tab.wait_for_status("Failed by a defect")
    assert "ZeroDivisionError: a defect" in caplog.text
    with opened(designer, 9) as again:
        again.wait_for_status("Feasible")


def test_a_state_that_led_to_a_defect_is_not_found_again(designer, monkeypatch):
    tab = opened(designer, 10)
    tab.wait_for_status("Feasible")
    session = session_of(designer, tab)

    def broken(*_args):
        raise ZeroDivisionError("a defect")

    monkeypatch.setattr(session._rendering, "draw", broken)
    tab.set("Forward [m]", 0.3)
    tab.wait_for_status("Failed by a defect")
    labels = [m["props"].get("label") for m in tab.controls.values()]
    assert [label for label in labels if label] == ["Reload"]  # no control does nothing
    tab.press("Reload")
    tab.wait(lambda: "window.location.reload()" in tab.scripts, "a fresh page")
    gone(designer, session)
    tab.close()
    assert session.left is None
    with opened(designer, 10) as again:
        again.wait_for_status("Feasible")
        assert again.value("Forward [m]") == 0.0


def test_a_slow_page_is_sent_the_newest_clip_next(designer, tab, session, script):
    tab.wait_for_status("Feasible")  # whose clip is there
    loads = len(script.calls("player.load"))
    taken, script.take = script.take, lambda source: None  # it does not take clips any more
    for forward in (0.1, 0.2, 0.3):
        tab.set("Forward [m]", forward)
        planned(tab, session, lambda jump, f=forward: jump.forward == f, "a plan")
    tab.wait_for_status("Feasible")
    sent = script.calls("player.load")
    assert len(sent) == loads + 1
    script.take = taken
    script.say(kind="clip", number=sent[-1][2])
    tab.wait(lambda: len(script.calls("player.load")) == loads + 2, "the newest")
    plan = session.state.plan
    end = plan.base_position[-1]
    assert script.at("/links/base", plan.duration)[0] == pytest.approx(end, abs=1e-5)


# ---- links and pages


def test_a_link_that_was_cut_is_one_line(designer, script, tab):
    with RawTab(designer.port, {"shared": "a link that was cut"}) as other:
        other.wait(lambda: other.notifications, "a note")
        assert other.notifications[0][0] == "The last design was not opened"
        assert other.notifications[0][1].startswith("the link: ")
        other.wait_for_status("Feasible")
    tab.page.say(kind="ready", software=True, shared="{}")
    tab.wait(lambda: tab.notifications, "a note")
    assert tab.notifications[0][0] == "Not opened"


def test_a_page_is_back_while_its_session_loads_a_robot(designer, monkeypatch):
    loading, go_on = threading.Event(), threading.Event()

    def slowly(self, outside):
        loading.set()
        go_on.wait(20)
        outside.inbox.put(loaded(self.name))

    with opened(designer, 40) as tab:
        tab.wait_for_status("Feasible")
        tab.set("Forward [m]", 0.3)
        tab.wait(lambda: session_of(designer, tab).state.plan.jump.forward == 0.3, "its plan")
        tab.press("Pin")
        tab.wait(lambda: session_of(designer, tab).state.pins, "a pin")
        monkeypatch.setattr(LoadRobot, "do", slowly)
        tab.set("Robot", "Unitree Go2")
        assert loading.wait(20)
        monkeypatch.undo()
    with opened(designer, 40) as again:  # the one before is still at it
        again.wait(lambda: again.value("Robot") == "Unitree Go2", "the robot")
        assert session_of(designer, again).state.pins
        go_on.set()
        again.wait_for_status("Feasible")
