"""Preferences that a browser keeps, and whatever else it may hand back."""

from dataclasses import replace

import pytest

from app.link import PageReady, SchemeChanged
from app.panel.view_controls import View
from app.plots.choice import DEFAULT, PRESETS
from app.tab.acts import update
from app.tab.start.opening import first_state
from app.tab.start.preferences import preferences, with_preferences
from llsrbm.robots import load_robot

STATE = first_state({"anymal": load_robot("anymal").file})


def met(state=STATE, **page):
    return update(state, PageReady(software=True, **page))[0]


def test_what_was_liked_is_found_again():
    liked = replace(
        met(),
        view=View(frozenset({"com", "reach"}), night=True, shortcuts=False),
        plots=PRESETS["Contact forces"],
        export=replace(STATE.export, format="csv"),
    )
    again = met(preferences=preferences(liked))
    assert again.view == liked.view
    assert again.plots == liked.plots
    assert again.export.format == "csv"


def test_a_visitor_who_chose_nothing_follows_the_system():
    dark = met(dark=True)
    assert dark.view.night
    assert '"night":null' in preferences(dark)
    assert not update(dark, SchemeChanged(dark=False))[0].view.night


def test_a_choice_stays_when_the_system_changes():
    chosen = replace(met(dark=True), view=View(night=False))
    assert not met(dark=True, preferences=preferences(chosen)).view.night
    assert not update(replace(chosen, dark=True), SchemeChanged(dark=True))[0].view.night


def test_a_page_that_greets_again_changes_nothing():
    state = replace(met(), view=View(night=True))
    assert update(state, PageReady(software=True))[0].view == state.view


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[]",
        '{"layers": 3}',
        '{"layers": ["no such"], "format": "no such", "plots": {"charts": [{"signal": "x"}]}}',
        '{"plots": {"charts": [{"signal": "com"}, {"signal": "com"}]}}',
    ],
)
def test_what_is_not_known_is_left_out(text):
    state = with_preferences(STATE, text, dark=False)
    assert state.plots == DEFAULT
    assert state.export == STATE.export
    assert state.view.layers in (STATE.view.layers, frozenset())
