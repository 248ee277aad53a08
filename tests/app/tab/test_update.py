"""`update`: events that change nothing else."""

from dataclasses import fields
from types import SimpleNamespace

import pytest

from app.link import (
    PageReady,
    PlaybackChosen,
    PlayerMoved,
)
from app.panel.acts import Act
from app.panel.view_controls import View
from app.plots.choice import PRESETS
from app.tab.acts import update
from app.tab.effects import Outside
from app.tab.planning.refining import WholeBody
from app.tab.state import TabState
from llsrbm.request.scenario import Scenario
from tests.app.pure_tab import PureTab, planned_tab


@pytest.mark.parametrize(
    ("event", "changed"),
    [
        (View(frozenset({"trails"}), night=True), {"view"}),
        (PRESETS["Base rates"], {"plots"}),
        (PlayerMoved(0.5, playing=True), {"playback"}),
        (PlaybackChosen(0.25, loop=False), {"playback"}),
        # With the preferences and the height that the page reports with itself.
        (PageReady(software=False), {"page", "fine", "plots", "view"}),
        (Act.SHARE, set()),
        (Act.SAVE, set()),
        (Act.CHOOSE_EXPORT, set()),
        (Act.STOP_FILES, set()),
        (Act.UNPIN, {"pins", "pin_chosen"}),
        (Act.NEAREST, set()),
        (WholeBody(False), {"whole_body"}),
        (Act.WORST, set()),
        (Act.USE_PINNED, set()),
        (Scenario(board=0.02), {"design", "history", "work", "answers"}),
    ],
)
def test_an_event_changes_only_its_own(event, changed):
    before = planned_tab().state
    after, _ = update(before, event)
    differing = {f.name for f in fields(TabState) if _of(before, f) is not _of(after, f)}
    assert differing <= changed


def _of(state, field):
    return getattr(state, field.name)


def test_a_graphics_processor_draws_all_triangles():
    state = planned_tab().state
    assert update(state, PageReady(software=False))[0].fine
    assert not update(state, PageReady(software=True))[0].fine


def test_a_page_that_comes_in_is_at_work():
    assert 'aria-busy="true"' in PureTab().state.status.html


class Notes:
    """A client that keeps the notes in sight."""

    def __init__(self):
        self.seen = []

    def add_notification(self, title, body, color):
        note = SimpleNamespace(body=body, remove=lambda: self.seen.remove(note))
        self.seen.append(note)
        return note


def test_a_note_takes_the_place_of_the_one_on_the_same_control():
    client = Notes()
    outside = Outside(client, None, None, None)
    for body in ("Seed: got 1", "Forward [m]: got 1", "Forward [m]: got 90.6"):
        outside.note("Corrected", body)
    assert [note.body for note in client.seen] == ["Seed: got 1", "Forward [m]: got 90.6"]
