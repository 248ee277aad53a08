"""Acts of the panel, and the inbox in which they wait for a session's thread."""

import pytest

from app.link import PushDragged
from app.panel.acts import Act, Button
from app.picture.foothold_handles import FootholdMoved
from app.picture.landing_handles import HandleMoved
from app.tab import acts
from app.tab.inbox import End, Inbox
from app.tab.planning.requests import Rested
from tests.app.pure_tab import PureTab, planned_tab


@pytest.mark.parametrize("act", Act, ids=lambda act: act.name)
def test_every_act_is_taken(act):
    assert isinstance(act.value, Button) == (act in acts._handlers)
    assert isinstance(act.value, Button) != (act in acts._readers)


HOW_FAR = ("FAR_TWIST", "FAR_FORWARD", "FAR_LATERAL", "FAR_HEIGHT")


def shown(tab):
    buttons = [act for act in Act if isinstance(act.value, Button)]
    return {
        a.name for a in buttons if acts.is_visible(a, tab.state) and acts.is_enabled(a, tab.state)
    }


def test_buttons_that_would_do_nothing_cannot_be_pressed():
    tab = PureTab()
    assert shown(tab) == {
        *("SIMULATE", "SHARE", "SEEDS", "SAVE", "ADD_CHART", "REMOVE_CHART"),
        *("COMPARE_MODELS", "EXAMPLES", "HELP", "DRAW_ROUTE", "ADD_LANDING"),
        *HOW_FAR,
    }
    tab = planned_tab()
    assert shown(tab) == {
        *(
            "SIMULATE",
            "SHARE",
            "SEEDS",
            "ROBOT_SIMULATOR",
            "SAVE",
            "CHOOSE_EXPORT",
            "EXPORT",
            "PIN",
            "UNDO",
            "CHECK",
        ),
        *("COMPARE_MODELS", "COMPARE_DRIVES", "EXAMPLES", "HELP"),
        *("DRAW_ROUTE", "ADD_LANDING"),
        *HOW_FAR,
        *("ADD_CHART", "REMOVE_CHART", "SAVE_LINES"),
    }
    tab.take(Act.PIN)
    tab.take(Act.EXPORT)
    tab.take(Act.UNDO)
    assert {"USE_PINNED", "UNPIN", "STOP_FILES", "CANCEL", "REDO"} <= shown(tab)
    assert "EXPORT" not in shown(tab)


def test_an_event_is_taken_by_one_function_alone():
    with pytest.raises(AssertionError, match="taken twice"):
        acts.on(Act.UNDO)(lambda state: state)


def taken(*items):
    inbox = Inbox()
    for item in items:
        inbox.put(item)
    return inbox.take()


GRABBED, LET_GO = HandleMoved(0, held=True), HandleMoved(0, held=False)
GRIPPED, DRAGGED, LEFT = (
    FootholdMoved(0, held=held, begins=begins)
    for held, begins in ((True, True), (True, False), (False, False))
)
HELD, ENDED = (PushDragged(0.4, 1.0, 0.0, ended=ended) for ended in (False, True))


@pytest.mark.parametrize(
    ("items", "left"),
    [
        # What was moved before a press counts for it, also if the same is moved again after it.
        ([Act.SCENARIO, Act.SIMULATE, Act.SCENARIO], [Act.SCENARIO, Act.SIMULATE, Act.SCENARIO]),
        ([Act.JUMP, Act.JUMP, Act.UNDO, Act.JUMP], [Act.JUMP, Act.UNDO, Act.JUMP]),
        ([Act.UNDO, Act.UNDO], [Act.UNDO, Act.UNDO]),
        ([GRABBED, GRABBED, LET_GO, Act.UNDO], [LET_GO, Act.UNDO]),
        ([GRABBED, HandleMoved(1, held=True)], [GRABBED, HandleMoved(1, held=True)]),
        ([HELD, HELD, ENDED, HELD], [ENDED, HELD]),
        ([GRIPPED, DRAGGED, DRAGGED, LEFT, GRIPPED], [GRIPPED, LEFT, GRIPPED]),
        ([DRAGGED, FootholdMoved(1, held=True)], [DRAGGED, FootholdMoved(1, held=True)]),
    ],
)
def test_only_neighbours_of_a_kind_are_one(items, left):
    assert taken(*items) == left


def test_what_is_due_comes_beside_what_has_happened():
    inbox = Inbox()
    inbox.put_later(0.0, Rested(1))
    inbox.put_later(0.0, Rested(2))  # in place of the one before
    inbox.put_later(60.0, End.END)
    inbox.put(Act.UNDO)
    assert inbox.take() == [Act.UNDO, Rested(2)]


def test_what_comes_while_the_page_is_waited_for_is_held_back():
    inbox = Inbox()
    inbox.put(Act.UNDO)
    inbox.put(End.END)
    assert inbox.wait_for_page(5) is None
    assert inbox.ended
    assert inbox.take() == [Act.UNDO, End.END]
