"""Controls made from a table: what a hand moves and what happens meanwhile are both kept."""

from collections import defaultdict
from dataclasses import dataclass, replace
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.panel.acts import Act
from app.panel.fields import Field, Fields


@dataclass(frozen=True)
class Shelf:
    number: float = 2.0
    ticked: bool = False
    chosen: str = "a"


def field(label, name, **how):
    return Field(
        label,
        f"What {label} means",
        get=lambda shelf: getattr(shelf, name),
        put=lambda shelf, shown: replace(shelf, **{name: shown}),
        **how,
    )


ROWS = {
    "number": field("Number", "number", ends=(0.0, 9.0)),
    "ticked": field("Ticked", "ticked"),
    "chosen": field("Chosen", "chosen", options=lambda shelf, letters: letters),
}
VALUES = {
    "number": st.integers(0, 9).map(float),
    "ticked": st.booleans(),
    "chosen": st.sampled_from("abc"),
}


class Gui:
    """As much of viser's as is needed: a control has what it was made with."""

    def __init__(self):
        self.sent = defaultdict(int)  # label -> how often it was set

    def add_number(self, label, value, **how):
        return self._made(label, value, how)

    def add_checkbox(self, label, value, **how):
        return self._made(label, value, how)

    def add_dropdown(self, label, options, *, initial_value, **how):
        return self._made(label, initial_value, {**how, "options": options})

    def _made(self, label, value, how):
        sent = self.sent

        class Control(SimpleNamespace):
            @property
            def value(self):
                return self.moved_to

            @value.setter
            def value(self, value):
                sent[label] += 1
                self.moved_to = value

        return Control(moved_to=value, on_update=lambda _: None, **how)


@pytest.fixture
def fields():
    return made()


def made():
    found = Fields(Gui(), Shelf(), ("a", "b", "c"), lambda _: None, Act.VIEW)
    found.add(*ROWS.values())
    return found


changes = st.sampled_from([*ROWS]).flatmap(lambda name: VALUES[name].map(lambda v: (name, v)))
EVENTS = st.lists(
    st.one_of(
        changes.map(lambda change: ("hand", *change)),
        changes.map(lambda change: ("elsewhere", *change)),
        st.just(("draw", None, None)),
    ),
    max_size=12,
)


@given(EVENTS)
def test_neither_a_move_nor_a_change_from_elsewhere_is_lost(events):
    """Every event is taken in its turn, whatever has been drawn of those before it."""
    fields, state = made(), Shelf()
    for kind, name, value in events:
        if kind == "hand":
            handle = fields.handle(ROWS[name])
            drawn = state if handle.moved_to == getattr(state, name) else None
            if handle.moved_to == value and drawn is None:
                continue  # nothing moves: a browser tells of no change
            handle.moved_to = value
            state, complaints = fields.read(state, ("a", "b", "c"))
            assert not complaints
            assert getattr(state, name) == value
        elif kind == "elsewhere":
            before, state = state, replace(state, **{name: value})
            read, _ = fields.read(state, ("a", "b", "c"))
            assert read == state, before
        else:
            fields.show(state, ("a", "b", "c"))
            for name_shown, row in ROWS.items():
                assert fields.handle(row).moved_to == getattr(state, name_shown)


@pytest.mark.parametrize("elsewhere", [3.0, 7.0])
def test_what_a_hand_is_moving_is_not_put_back(fields, elsewhere):
    handle = fields.handle(ROWS["number"])
    handle.moved_to = 3.0
    state, _ = fields.read(Shelf(), ())
    handle.moved_to = 4.0  # on its way to the session while another number is drawn
    fields.show(replace(state, number=elsewhere), ("a", "b", "c"))
    assert handle.moved_to == 4.0
    assert fields.read(state, ())[0].number == 4.0


@pytest.mark.parametrize(
    ("row", "sent", "taken"), [("number", 99.0, 9.0), ("number", "x", 0.0), ("chosen", "z", "a")]
)
def test_what_cannot_be_is_corrected_and_the_control_put_right(fields, row, sent, taken):
    handle = fields.handle(ROWS[row])
    handle.moved_to = sent
    state, (complaint,) = fields.read(Shelf(), ())
    assert complaint.startswith(f"{ROWS[row].label}: expected")
    assert getattr(state, row) == taken
    fields.show(state, ("a", "b", "c"))
    assert handle.moved_to == taken


def test_a_menu_offers_what_is_chosen_as_long_as_it_is(fields):
    handle = fields.handle(ROWS["chosen"])
    fields.show(Shelf(chosen="c"), ("a", "b"))
    assert (handle.options, handle.moved_to) == (("a", "b", "c"), "c")
    fields.show(Shelf(chosen="a"), ("a", "b"))
    assert handle.options == ("a", "b")


def test_nothing_is_sent_of_what_stays(fields):
    for _ in range(3):
        fields.show(Shelf(), ("a", "b", "c"))
    assert not fields._gui.sent
