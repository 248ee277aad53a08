"""The examples as cards with moving pictures, and one that is chosen."""

import base64
import io
import json
from dataclasses import replace

import pytest
from PIL import Image

from app import gallery
from app.link import CardsAsked, ExampleChosen, FiguresWanted, MotionChosen
from app.panel.acts import Act
from app.tab.effects import Queue, ShowGallery
from app.workers.opened_file import OpenedFile
from app.workers.reports import Opened
from app.workers.tasks import OpenMotion
from llsrbm.library import shipped
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


# ---- the library


def test_every_motion_has_a_line():
    motions = gallery.motions()
    assert [motion["name"] for motion in motions] == sorted(gallery.motion_names())
    assert all("s in the air" in motion["line"] for motion in motions)


def test_kinds_have_the_titles_of_the_menu_of_jump_types():
    kinds = {motion["kind"] for motion in gallery.motions()}
    assert {"All feet together", "Hops", "Back flip", "Pirouette"} <= kinds
    assert all(kind[0].isupper() for kind in kinds)


def test_every_motion_has_a_stick_figure_and_each_is_small():
    found = gallery.stick_figures(gallery.motion_names())
    assert found.keys() == gallery.motion_names()
    assert max(len(json.dumps(drawn)) for drawn in found.values()) < 4_000
    durations = {card.name: card.figures.duration_s for card in shipped().cards}
    for name, drawn in found.items():
        assert drawn["duration"] == pytest.approx(durations[name], abs=1e-3)


class Outside:
    """Keeps what is called in the page."""

    has_gallery = False

    def __init__(self):
        self.link, self.called = self, []

    def call(self, function, *arguments):
        self.called.append((function, *arguments))


def test_cards_are_sent_once_and_no_stick_figure_with_them():
    outside = Outside()
    for shown in (False, True, True):
        ShowGallery(shown).do(outside)
    assert [call[0] for call in outside.called] == ["gallery.fill", "gallery.open", "gallery.open"]


def test_stick_figures_are_sent_of_motions_that_come_into_view():
    (effect,) = planned_tab().take(FiguresWanted(("go2-together-0001", "go2-together-9999")))
    outside = Outside()
    effect.do(outside)
    ((function, figures),) = outside.called
    assert function == "gallery.animate"
    assert figures == gallery.stick_figures(["go2-together-0001"])
    assert figures["go2-together-0001"]["bytes"]


def test_figures_that_are_nothing_are_left_out():
    card = shipped().card("go2-together-0001")
    still = replace(card.figures, forward_m=0.0, lateral_m=0.0, height_m=-0.2, turn=0.01)
    assert (
        gallery.figures_in_words(replace(still, flight_s=0.4)) == "down 0.20 m, 0.40 s in the air"
    )


def test_the_motion_that_is_chosen_is_opened_as_a_file_is():
    tab = planned_tab()
    name = "go2-together-0001"
    tab.take(MotionChosen(name))
    assert tab.one.queue is Queue.OPEN
    assert isinstance(tab.one.task, OpenMotion)
    plan = shipped().open(name, check=False)
    tab.report(Opened(0, OpenedFile(name, plan)))
    assert tab.state.design.jump == plan.jump


def test_a_motion_that_there_is_not_changes_nothing():
    tab = planned_tab()
    assert tab.take(MotionChosen("go2-together-9999")) == ()
