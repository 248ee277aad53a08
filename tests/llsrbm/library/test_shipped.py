"""The library that ships: small, all of it certified and strict, and opened by anybody."""

import hashlib
import json

import pytest

from llsrbm.certificate import certify
from tests.llsrbm.library.shipped_motions import first_of_each_robot, library

MOST_BYTES = 12_000_000


def test_it_is_small_and_every_motion_is_certified_and_strict():
    assert sum(path.stat().st_size for path in library().files) < MOST_BYTES
    cards = library().cards
    assert len({card.name for card in cards}) == len(cards) > 0
    assert all(card.certified for card in cards)
    # Flips are added as they are.
    assert all(card.simulated.all_strict for card in cards if not card.request.turns)


def test_flips_are_found_and_hold_their_certificates():
    flips = library().found(["go2", "flip"])
    assert {card.kind for card in flips} == {"back-flip", "front-flip"}
    assert all(library().open(card.name).certified for card in flips)
    assert all(card.simulated.seeds > 1 for card in flips)


@pytest.mark.parametrize("name", first_of_each_robot())
def test_a_certificate_that_is_checked_again_holds(name):
    plan = library().open(name)
    card = library().card(name)
    assert plan.certified
    for check, finding in certify(plan).as_dict().items():
        assert finding["holds"]
        worst = card.certificate[check]["worst"]
        assert finding["worst"] == (None if worst is None else pytest.approx(worst, abs=1e-3))
    assert plan.jump == card.request
    assert plan.airborne == pytest.approx(card.figures.flight_s, abs=1e-6)


def test_its_card_has_the_checksums_of_its_files():
    found = json.loads((library().folder / "card.json").read_text("utf-8"))
    assert found["motions"] == len(library().cards)
    stated = {file["name"]: file["sha256"] for file in found["files"]}
    assert stated == {
        path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in library().files
    }
