"""`update`: events that change nothing else."""

from dataclasses import fields

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
from app.tab.planning.refining import WholeBody
from app.tab.state import TabState
from llsrbm.request.scenario import Scenario
from tests.app.pure_tab import planned_tab


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
