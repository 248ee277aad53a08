"""The card of a library, and its README."""

import json

from llsrbm.library import Library
from llsrbm.library.card import Simulated
from llsrbm.library.description import describe, write_description
from tests.llsrbm.library.shipped_motions import library, plan


def test_counts_and_ranges():
    found, cards = describe(library()), library().cards
    assert sum(found["kinds"].values()) == found["motions"] == len(cards)
    assert sum(own["motions"] for own in found["robots"].values()) == len(cards)
    assert found["certified"] == len(cards)
    low, high = found["ranges"]["flight_s"]
    assert low == min(card.figures.flight_s for card in cards)
    assert high == max(card.figures.flight_s for card in cards)
    assert all(check["holds"] == len(cards) for check in found["checks"].values())
    assert found["checks"]["dynamics"]["largest"] <= 0.1


def test_it_is_written_and_says_what_was_simulated(tmp_path):
    own = Library(tmp_path)
    own.add(plan(), Simulated(4, 4, 3))
    own.packed()
    found = write_description(own)
    assert json.loads((tmp_path / "card.json").read_text()) == found
    text = (tmp_path / "README.md").read_text()
    assert "3 of 4 simulations landed strictly" in text
    assert "BSD-3-Clause" in text


def test_an_empty_library_has_a_card(tmp_path):
    assert describe(Library(tmp_path))["motions"] == 0
