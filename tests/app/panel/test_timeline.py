from __future__ import annotations

import re
from dataclasses import replace
from html import unescape

import pytest

from app.motion import colours
from app.panel.timeline import html
from llsrbm.jump import Jump
from llsrbm.motion.timeline import phase_at, timeline
from tests.app.synthetic_plan import FLY, STAND, synthetic_plan
from tests.llsrbm.synthetic_rollout import FORCE_PHASE, STANDING, synthetic_rollout

END = 2 * STAND + FLY + STANDING
TOUCHDOWN, DETECTED = STAND + FLY - 0.01, STAND + FLY - 0.005


@pytest.fixture(scope="module")
def plan():
    return synthetic_plan(Jump(twist=1.0))


@pytest.fixture(scope="module")
def rollout(plan):
    return synthetic_rollout(plan)


def text(markup):
    return unescape(re.sub(r"<[^>]*>", "", markup))


def marks(events):
    return {mark.name: mark.time for mark in events.marks}


def stretches(row):
    return [(piece.name, piece.start, piece.end) for piece in row.pieces]


def near(expected):
    return [
        (name, pytest.approx(a, abs=2e-3), pytest.approx(b, abs=2e-3)) for name, a, b in expected
    ]


def places(markup, thing):
    """(left, width) of what has this title, shares of the strip."""
    found = re.findall(rf'title="{thing}[^"]*"[^>]*left:([\d.]+)%;width:([\d.]+)(?:%|px)', markup)
    return [tuple(float(value) / 100 for value in pair) for pair in found]


@pytest.mark.parametrize(
    ("instant", "phase"),
    [(0.1, "take-off"), (0.6, "flight"), (0.896, "landing"), (1.2, "landing"), (1.9, "standing")],
)
def test_it_says_which_phase_it_is(plan, rollout, instant, phase):
    events = timeline(plan, rollout)
    assert phase_at(events, instant) == phase
    assert text(html(events, instant)).startswith(f"{phase} {instant:.2f} s of 2.30 s")


def test_a_plan_alone_ends_with_its_landing(plan):
    events = timeline(plan)
    lift_off, touchdown, end = STAND, STAND + FLY, 2 * STAND + FLY
    (row,) = events.rows
    assert stretches(row) == near(
        [
            ("take-off", 0, lift_off),
            ("flight", lift_off, touchdown),
            ("landing", touchdown, end),
        ]
    )
    assert events.end == pytest.approx(end)
    told = text(html(events, 1.3))
    assert told == "landing 1.30 s of 1.30 s · lift-off 0.40 s, touch-down 0.90 s"


def test_what_happens_is_marked_where_it_happens(plan, rollout):
    planned = {"take-off": STAND, "touch-down planned": STAND + FLY}
    found = marks(timeline(plan))
    apex = found.pop("apex")
    assert found == pytest.approx(planned)
    # As high as it gets, between two knots.
    assert apex == pytest.approx(STAND + FLY / 2, abs=FLY / 16)
    found = marks(timeline(plan, rollout))
    assert found.pop("apex") == apex
    assert found == pytest.approx(planned | {"first contact": TOUCHDOWN, "detected": DETECTED})


def test_marks_come_in_their_order_in_time_and_tell_plan_and_simulation_apart(plan, rollout):
    found = timeline(plan, rollout).marks
    assert [mark.time for mark in found] == sorted(mark.time for mark in found)
    simulated = {mark.name for mark in found if mark.colour == colours.SIMULATED}
    assert simulated == {"first contact", "detected"}


def test_a_simulation_has_a_strip_of_its_own(plan, rollout):
    planned, simulated = timeline(plan, rollout).rows
    assert stretches(planned)[-1] == near([("standing", plan.duration, END)])[0]
    *phases, force = stretches(simulated)
    assert phases == near(
        [
            ("take-off", 0, STAND),
            ("flight", STAND, DETECTED),
            ("landing", DETECTED, plan.duration),
            ("standing", plan.duration, END),
        ]
    )
    assert force == near([("force control", DETECTED, DETECTED + FORCE_PHASE)])[0]
    assert [piece.low for piece in simulated.pieces] == [False] * 4 + [True]


def test_it_is_drawn_where_it_is(plan, rollout):
    markup = html(timeline(plan, rollout), 0.0)
    ((detected, _),) = places(markup, "detected")
    ((begin, length),) = places(markup, "force control")
    assert detected == pytest.approx(DETECTED / END, abs=1e-4)
    assert begin == pytest.approx(DETECTED / END, abs=1e-4)
    assert length == pytest.approx(FORCE_PHASE / END, abs=2e-3)
    assert "touch-down 0.900 s planned, 0.890 s simulated, detected +5.0 ms" in text(markup)


def test_a_missed_touchdown_is_told(plan, rollout):
    blind = replace(rollout, outcome=replace(rollout.outcome, touchdown_detected_s=None))
    events = timeline(plan, blind)
    assert "0.890 s simulated, not detected" in events.told
    assert "detected" not in marks(events)


def test_no_contact_at_all_is_told(plan, rollout):
    outcome = replace(rollout.outcome, touchdown_true_s=None, touchdown_detected_s=None)
    events = timeline(plan, replace(rollout, outcome=outcome))
    assert "planned, none simulated, not detected" in events.told
    assert "first contact" not in marks(events)


def test_a_fall_ends_its_strip_early_and_is_marked(plan):
    events = timeline(plan, synthetic_rollout(plan, fell_at=0.65))
    planned, simulated = events.rows
    assert max(end for _, _, end in stretches(simulated)) == pytest.approx(0.65, abs=5e-3)
    assert max(end for _, _, end in stretches(planned)) == plan.duration
    assert marks(events)["fell"] == pytest.approx(0.65, abs=5e-3)
