"""The registry: every act of the panel is taken, and says when its button can be pressed."""

from __future__ import annotations

import pytest

from app.panel.acts import Act, Button
from app.tab import acts
from tests.app.pure_tab import PureTab, planned_tab


@pytest.mark.parametrize("act", Act, ids=lambda act: act.name)
def test_every_act_is_taken(act):
    assert isinstance(act.value, Button) == (act in acts._handlers)
    assert isinstance(act.value, Button) != (act in acts._readers)


def shown(tab):
    buttons = [act for act in Act if isinstance(act.value, Button)]
    return {
        a.name for a in buttons if acts.is_visible(a, tab.state) and acts.is_enabled(a, tab.state)
    }


def test_buttons_that_would_do_nothing_cannot_be_pressed():
    tab = PureTab()
    assert shown(tab) == {"SIMULATE", "SHARE", "SEEDS", "SAVE"}
    tab = planned_tab()
    assert shown(tab) == {"SIMULATE", "SHARE", "SEEDS", "SAVE", "EXPORT", "PIN", "UNDO"}
    tab.take(Act.PIN)
    tab.take(Act.EXPORT)
    tab.take(Act.UNDO)
    assert {"USE_PINNED", "UNPIN", "STOP_FILES", "CANCEL", "REDO"} <= shown(tab)
    assert "EXPORT" not in shown(tab)


def test_an_event_is_taken_by_one_function_alone():
    with pytest.raises(AssertionError, match="taken twice"):
        acts.on(Act.UNDO)(lambda state: state)
