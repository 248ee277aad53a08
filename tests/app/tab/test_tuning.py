"""Weights and limits that are typed into the page's table."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.link import TuningChosen, read_event
from app.panel.acts import Act
from app.panel.tuning import entries_of
from app.tab.acts import update
from app.tab.effects import Notify, ShowTuning
from app.tab.start.opening import first_state
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot, read_robot_file
from llsrbm.robots.schema import robot_files

FILES = {name: read_robot_file(path) for name, path in robot_files().items()}
ROBOT = load_robot("anymal")
ENTRIES = {(entry.group, entry.name): entry for entry in entries_of(ROBOT, "together")}
FRICTION = ENTRIES["limits", "friction"]


@pytest.fixture(scope="module")
def state():
    return replace(first_state(FILES), robot=ROBOT)


def tuned(state, *events):
    effects = ()
    for event in events:
        state, effects = update(state, event)
    return state.design.tuning, [e for e in effects if isinstance(e, Notify | ShowTuning)]


def test_a_number_is_changed_and_put_back(state):
    change = TuningChosen("limits", "friction", 0.4)
    assert tuned(state, change) == (tuning_of(limits={"friction": 0.4}), [])
    assert not tuned(state, change, TuningChosen("limits", "friction", None))[0]
    assert not tuned(state, change, TuningChosen("limits", "friction", FRICTION.default))[0]


def test_all_are_reset_at_once_and_that_can_be_undone(state):
    for event in (TuningChosen("limits", "friction", 0.4), TuningChosen("weights", "tilt", 7.0)):
        state, _ = update(state, event)
    state, _ = update(state, Act.RESET_TUNING)
    assert not state.design.tuning
    assert state.history.back[-1].tuning == tuning_of({"tilt": 7.0}, {"friction": 0.4})


@settings(max_examples=50, deadline=None)
@given(key=st.sampled_from(sorted(ENTRIES)), value=st.floats(-1e9, 1e9))
def test_beyond_its_range_the_nearest_is_taken_and_said(state, key, value):
    entry = ENTRIES[key]
    tuning, notes = tuned(state, TuningChosen(*key, value))
    taken = {**tuning.weights, **tuning.limits}.get(entry.name, entry.default)
    nearest = min(max(value, entry.lowest), entry.highest)
    assert taken == pytest.approx(nearest, rel=2e-6, abs=2e-6)
    outside = abs(nearest - value) > 1e-5 * max(1.0, abs(value))
    if outside:
        note, reset = notes
        assert f"{entry.title}: expected" in note.body
        assert reset == ShowTuning(tuning)


def test_a_name_that_does_not_exist_is_said(state):
    tuning, (note,) = tuned(state, TuningChosen("weights", "friction", 1.0))
    assert not tuning
    assert note.body == "ANYmal B has no such number."


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        ('"group": "limits", "name": "friction", "value": 1', ("limits", "friction", 1.0)),
        ('"group": "weights", "name": "tilt", "value": null', ("weights", "tilt", None)),
        ('"group": "other", "name": "tilt", "value": 1', None),
        ('"group": "weights", "name": 3, "value": 1', None),
        ('"group": "weights", "name": "tilt", "value": "1"', None),
        ('"group": "weights", "name": "tilt", "value": NaN', None),
        ('"group": "weights", "name": "tilt", "value": 1e999', None),
        ('"group": "weights", "name": "tilt"', None),
        (f'"group": "weights", "name": "{"x" * 200}", "value": 1', None),
    ],
)
def test_what_a_page_sends_is_checked(message, expected):
    event = read_event(f'{{"kind": "tuning", {message}, "count": 3}}')
    assert event == (None if expected is None else TuningChosen(*expected))


def tuning_of(weights=None, limits=None):
    return Tuning(weights or {}, limits or {})
