"""The examples as cards with moving pictures, and one that is chosen."""

import base64
import io

import pytest
from PIL import Image

from app import gallery
from app.link import CardsAsked, ExampleChosen
from app.panel.acts import Act
from app.tab.effects import ShowGallery
from llsrbm.request.design import examples
from tests.app.pure_tab import planned_tab

MOST = 700_000  # bytes of all pictures: half a second at 10 Mbit/s
LINE = 130  # characters, two lines of a card


def test_every_example_has_a_card_and_the_pirouette_is_first():
    cards = gallery.cards()
    assert {card["name"] for card in cards} == set(examples())
    assert cards[0]["name"] == "g1-pirouette"
    for card in cards:
        design = examples()[card["name"]]
        assert card["title"] == design.title
        assert 0 < len(card["line"]) <= LINE
        assert design.note.startswith(card["line"])


@pytest.mark.parametrize("name", examples())
def test_its_picture_ships_and_moves(name):
    (card,) = (card for card in gallery.cards() if card["name"] == name)
    kind, _, content = card["picture"].partition(",")
    assert kind == "data:image/webp;base64"
    with Image.open(io.BytesIO(base64.b64decode(content))) as picture:
        assert picture.size == (192, 144)
        assert picture.n_frames >= 10
        first = picture.convert("L").tobytes()
        picture.seek(picture.n_frames // 2)
        assert picture.convert("L").tobytes() != first


def test_all_pictures_are_small():
    assert sum(path.stat().st_size for path in gallery.FOLDER.iterdir()) < MOST


def test_a_note_is_cut_after_its_first_sentence():
    assert gallery.first_sentence("Look at 0.5 m. And then there.") == "Look at 0.5 m."
    assert gallery.first_sentence("Look: it flies.") == "Look: it flies."


@pytest.mark.parametrize(("event", "shown"), [(Act.EXAMPLES, True), (CardsAsked(), False)])
def test_it_is_shown_when_it_is_to_be_seen(event, shown):
    tab = planned_tab()
    before = tab.state
    assert tab.take(event) == (ShowGallery(shown),)
    assert tab.state is before


def test_the_one_that_is_chosen_is_planned_and_can_be_undone():
    tab = planned_tab()
    before = tab.state.design
    tab.take(ExampleChosen("anymal-board"))
    chosen = examples()["anymal-board"]
    assert tab.state.design == chosen
    assert tab.state.note == chosen.note
    tab.take(Act.UNDO)
    assert tab.state.design == before


def test_an_example_that_there_is_not_changes_nothing():
    tab = planned_tab()
    before = tab.state
    assert tab.take(ExampleChosen("nosuch")) == ()
    assert tab.state is before
