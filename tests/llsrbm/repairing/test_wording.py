"""A repair in words."""

from dataclasses import replace

from llsrbm.certificate import Certificate, Finding
from llsrbm.repairing.result import Moved, Repair
from llsrbm.repairing.wording import (
    broken_checks,
    check_rows,
    checked_sentence,
    moved_in_words,
    repair_sentences,
)

SPEED = Finding("joint_speed", 1.164, 30.1, "rad/s", "FL_calf_joint", 0.74, False, 1.01, "", 0.012)
SLIP = Finding("slip", 0.0131, 0.01, "m", "FR", 1.2, False, 0.01)
REACHED = Finding("joint_position", 0.98, 2.7, "rad", "FL_calf_joint", 0.5, True, 1.01)
UNKNOWN = Finding("dynamics", None, None, "N", "", None, None, why="it has no contact forces")
NOTHING = Finding("winding_heat", None, None, "J", "", None, True, why="no heat in the file")
BEFORE = Certificate((REACHED, SPEED, SLIP, NOTHING, UNKNOWN))
AFTER = Certificate(
    (
        REACHED,
        *(
            replace(each, worst=0.5 * each.worst, holds=True, beyond_s=None)
            for each in (SPEED, SLIP)
        ),
        NOTHING,
        replace(UNKNOWN, worst=0.04, where="moment", time_s=0.6, holds=True),
    )
)
MOVED = Moved(0.0523, 0.034, 0.012, (0.0, 0.1, 0.0))
SPEED_WORDS = "joint speed 116.4 % at FL_calf_joint (0.74 s, 12 ms beyond)"
SLIP_WORDS = "slip 13.1 mm against 10.0 mm at FR (1.20 s)"


def test_broken_checks_are_said_with_amount_place_and_instant():
    assert checked_sentence(BEFORE) == (
        f"2 of 5 checks broken (1 not known): {SPEED_WORDS}; {SLIP_WORDS}."
    )
    assert broken_checks(BEFORE).startswith("joint_speed 116.4 % at FL_calf_joint (0.74 s, ")


def test_the_worst_come_in_the_order_of_the_checks_and_the_rest_is_counted():
    many = Certificate((SPEED, SLIP) * 3)
    assert checked_sentence(many).endswith("and 3 more.")


def test_that_all_holds_is_said_as_far_as_it_is_known():
    assert checked_sentence(AFTER) == "All 5 checks hold."
    assert broken_checks(AFTER) == "holds"
    held = Certificate((REACHED, UNKNOWN))
    assert checked_sentence(held) == "All 1 known checks hold (1 not known)."
    assert broken_checks(held) == "holds as far as it is known"


def test_a_repair_says_before_after_and_how_far():
    found = Repair("repaired", BEFORE, AFTER, MOVED, why="It is played faster.")
    moved = "joints 0.052 rad (rms), base 3.4 cm (rms), landing 1.2 cm"
    assert moved_in_words(MOVED) == moved
    assert repair_sentences(found) == (
        "Before, in the file's own time: 2 of 5 checks broken (1 not known): "
        f"{SPEED_WORDS}; {SLIP_WORDS}. After: all 5 checks hold. Moved: {moved}. "
        "It is played faster."
    )


def test_one_that_can_be_done_says_so():
    words = repair_sentences(Repair("unchanged", AFTER, AFTER, MOVED))
    assert words.startswith("Before: all 5 checks hold. After: all 5 checks hold. It can be done")


def test_one_that_failed_says_why():
    assert repair_sentences(Repair("failed", BEFORE, why="No foot leaves.")).endswith(
        "Not repaired: No foot leaves."
    )


def test_rows_have_what_is_known_and_broken_checks_first():
    rows = check_rows(BEFORE, AFTER)
    assert [name for name, _ in rows] == ["joint speed", "slip", "joint position", "dynamics"]
    assert dict(rows)["slip"] == ("✗ 13.1 mm, FR, 1.20 s", "✓ 6.6 mm, FR, 1.20 s")
    assert dict(rows)["dynamics"] == ("not known", "✓ 4.0 %, moment, 0.60 s")
    assert [name for name, _ in check_rows(BEFORE)] == ["joint speed", "slip", "joint position"]
